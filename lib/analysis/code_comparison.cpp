#include "analysis/code_comparison.h"

#include <algorithm>
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

/// The mean over turns of the tool. Variances of what is left have up to four periods a turn where every station is
/// corrected for itself; those of an estimate of the run are nearly so.
constexpr int kTurns = 8;

CorrectedErrors errors_left(const MeasuredStations& stations, const survey::Survey& survey, const CodeCase& which,
                            const Correction& correction) {
  CorrectedErrors mean = corrected_errors(stations, which.draws, which.noise, correction, which.correlation);
  if (!which.turned) return mean;
  for (int i = 1; i < kTurns && mean.determined; ++i) {
    survey::Survey turned = survey;
    for (survey::Station& s : turned.stations) s.toolface += i * 2 * kPi / kTurns;
    const CorrectedErrors e =
        corrected_errors(measured_stations(turned, stations.field, which.claimed->first_leg_doubled()), which.draws,
                         which.noise, correction, which.correlation);
    mean.determined = e.determined;
    mean.condition = std::max(mean.condition, e.condition);
    mean.limits = worse_of(mean.limits, e.limits);
    for (std::size_t input = 0; input < kCodeInputs; ++input) {
      mean.position[input] += e.position[input];
      if (!e.determined) continue;
      for (std::size_t k = 0; k < mean.azimuth.size(); ++k) mean.azimuth[k][input] += e.azimuth[k][input];
    }
  }
  for (Eigen::Matrix3d& c : mean.position) c /= kTurns;
  for (auto& station : mean.azimuth)
    for (double& v : station) v /= kTurns;
  return mean;
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
  c.before = errors_left(c.stations, survey, which, {});
  c.after = which.correction.kind == Correction::Kind::none ? c.before
                                                            : errors_left(c.stations, survey, which, which.correction);
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

double horizontal_field_sd(const propagate::CodeDraws& d, const survey::ReferenceField& field) {
  const double horizontal = field.total * std::cos(field.dip), vertical = field.total * std::sin(field.dip);
  return std::hypot(
      std::hypot(d.run.total, d.station.total) * std::cos(field.dip), vertical * std::hypot(d.run.dip, d.station.dip),
      std::hypot(d.sensors[survey::kMagnetometerBias], d.sensors[survey::kMagnetometerScale] * horizontal));
}

double axial_kappa(const propagate::CodeDraws& draws, const survey::ReferenceField& field, double inclination,
                   double azimuth) {
  const double along_east = std::sin(inclination) * std::sin(azimuth - field.declination);
  return horizontal_field_sd(draws, field) / (field.total * std::cos(field.dip) * (1 - along_east * along_east));
}

double axial_half_angle(const propagate::CodeDraws& draws, const survey::ReferenceField& field) {
  const double square = horizontal_field_sd(draws, field) / (kLargestKappa * field.total * std::cos(field.dip));
  return square < 1 ? std::asin(std::sqrt(square)) : kPi / 2;
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
