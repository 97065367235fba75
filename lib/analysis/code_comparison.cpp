#include "analysis/code_comparison.h"

#include <cmath>

#include "base/standard_deviation.h"
#include "base/units.h"

namespace surveymc::analysis {
namespace {

/// Variances by input; their sum is that of the quantity.
std::array<double, kCodeInputs> variances(const CorrectedErrors& e, const CodeComparison& c, const survey::Survey& s,
                                          CodeQuantity quantity) {
  std::array<double, kCodeInputs> v{};
  if (!e.determined) {
    v.fill(kNaN);
    return v;
  }
  if (quantity == CodeQuantity::azimuth) return e.azimuth.back();
  const Eigen::RowVector3d along = code_direction(c, s, quantity);
  for (std::size_t i = 0; i < kCodeInputs; ++i) v[i] = along * e.position[i] * along.transpose();
  return v;
}

double variance(const Eigen::Matrix3d& c, const Eigen::RowVector3d& along) { return along * c * along.transpose(); }

}  // namespace

CodeComparison compare_code(const survey::Survey& survey, const survey::ReferenceField& field, const CodeCase& which,
                            bool with_carried) {
  CodeComparison c;
  c.stations = measured_stations(survey, field, which.claimed->first_leg_doubled());
  c.magnetic = which.claimed->magnetic(survey, field);
  c.carried.azimuth.assign(survey.stations.size(), 0);
  if (with_carried) c.carried = which.claimed->carried(survey, field);
  c.before = corrected_errors(c.stations, which.draws, which.noise, {});
  c.after = which.correction.kind == Correction::Kind::none
                ? c.before
                : corrected_errors(c.stations, which.draws, which.noise, which.correction);
  return c;
}

Eigen::RowVector3d code_direction(const CodeComparison& c, const survey::Survey& s, CodeQuantity quantity) {
  const survey::Station& last = s.stations.back();
  switch (quantity) {
    case CodeQuantity::high_side:
      return survey::rotation_hla_from_nev(last.inclination, last.azimuth).row(0);
    case CodeQuantity::north:
      return {1, 0, 0};
    case CodeQuantity::east:
      return {0, 1, 0};
    case CodeQuantity::worst: {
      const Eigen::Matrix3d actual = (c.after.determined ? c.after : c.before).covariance();
      const Eigen::Vector2d u =
          worst_direction(actual.topLeftCorner<2, 2>(), c.magnetic.position.topLeftCorner<2, 2>());
      return {u.x(), u.y(), 0};
    }
    case CodeQuantity::lateral:
    case CodeQuantity::azimuth:
      break;
  }
  return survey::rotation_hla_from_nev(last.inclination, last.azimuth).row(1);
}

CodeSds code_sds(const CodeComparison& c, const survey::Survey& s, CodeQuantity quantity, CodeScope scope,
                 std::size_t station) {
  const bool all = scope == CodeScope::total;
  CodeSds out;
  if (quantity == CodeQuantity::azimuth) {
    const double carried = all ? c.carried.azimuth[station + 1] : 0;
    out.claimed = standard_deviation(c.magnetic.azimuth[station + 1] + carried);
    out.before = standard_deviation(c.before.azimuth_variance(station) + carried);
    out.after = c.after.determined ? standard_deviation(c.after.azimuth_variance(station) + carried) : kNaN;
    return out;
  }
  const Eigen::Matrix3d carried = all ? c.carried.position : Eigen::Matrix3d(Eigen::Matrix3d::Zero());
  const Eigen::Matrix3d claimed = c.magnetic.position + carried, before = c.before.covariance() + carried,
                        after = c.after.covariance() + carried;
  const Eigen::RowVector3d along = code_direction(c, s, quantity);
  out.claimed = standard_deviation(variance(claimed, along));
  out.before = standard_deviation(variance(before, along));
  out.after = c.after.determined ? standard_deviation(variance(after, along)) : kNaN;
  if (quantity == CodeQuantity::worst) {
    // Each against the claim in its own worst direction; the claim is shown in that of `along`.
    const auto worst = [&](const Eigen::Matrix3d& actual) {
      return out.claimed * worst_ratio(actual.topLeftCorner<2, 2>(), claimed.topLeftCorner<2, 2>());
    };
    out.before = worst(before);
    if (c.after.determined) out.after = worst(after);
  }
  return out;
}

std::string code_verdict(double ratio, double margin) {
  if (std::isnan(ratio)) return "undetermined";
  return ratio <= 1 + margin ? "holds" : "broken";
}

std::string code_verdict(double low, double high, double margin) {
  if (std::isnan(low) || std::isnan(high)) return "undetermined";
  return high < 1 + margin ? "holds" : low > 1 + margin ? "broken" : "undecided";
}

std::string code_class(const std::string& before, const std::string& after) {
  if (after == "undetermined") return after;
  if (after == "undecided" || before == "undecided") return "undecided";
  const bool held = before == "holds";
  return after == "holds" ? (held ? "free" : "kept") : (held ? "harmful" : "broken");
}

CodeRequirement code_requirement(const CodeComparison& c, const survey::Survey& s, CodeQuantity quantity,
                                 double margin) {
  const std::array<double, kCodeInputs> v = variances(c.after, c, s, quantity);
  double all = 0;
  for (const double x : v) all += x;
  const double sd = quantity == CodeQuantity::azimuth
                        ? standard_deviation(c.magnetic.azimuth.back())
                        : standard_deviation(variance(c.magnetic.position, code_direction(c, s, quantity)));
  const double most = (1 + margin) * (1 + margin) * sd * sd;
  const auto factor = [&](double part) {
    const double rest = all - part;
    if (!(rest <= most)) return kNaN;
    return part > 0 ? std::sqrt((most - rest) / part) : kInfinity;
  };
  return {factor(v[kTotalField] + v[kDip]), factor(v[kInterference])};
}

std::array<double, kCodeInputs> code_budget(const CorrectedErrors& e, const CodeComparison& c, const survey::Survey& s,
                                            CodeQuantity quantity) {
  std::array<double, kCodeInputs> v = variances(e, c, s, quantity);
  double all = 0;
  for (const double x : v) all += x;
  for (double& x : v) x /= all;
  return v;
}

}  // namespace surveymc::analysis
