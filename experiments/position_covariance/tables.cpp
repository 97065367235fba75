#include "position_covariance/tables.h"

#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "propagate/ellipse.h"
#include "study/table_rows.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::position_covariance {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr const char* kNevCovariance = "covariance, north, east, vertical (down), true north";

/// [0, 360); 0 for a vertical direction.
double azimuth_deg(const Vector3d& v) {
  if (std::hypot(v.x(), v.y()) < 1e-12) return 0;
  const double a = std::atan2(v.y(), v.x()) / kDegree;
  return a < 0 ? a + 360 : a;
}

}  // namespace

store::Table covariance_table(const survey::Survey& survey, const propagate::PositionCovariances& result) {
  study::TableRows t("covariance", "position covariance of every station; standard deviations and axes are one sigma");
  for (std::size_t k = 0; k < survey.stations.size(); ++k) {
    const survey::Station& s = survey.stations[k];
    const Matrix3d &c = result.total[k], to_hla = survey::rotation_hla_from_nev(s.inclination, s.azimuth);
    const Matrix3d hla = to_hla * c * to_hla.transpose();
    const auto sd = [&](const char* direction, double variance) {
      t.number(fmt::format("sd_{}_m", direction), "m", "one standard deviation", std::sqrt(std::max(0.0, variance)));
    };
    t.number("md_m", "m", "measured depth", s.md);
    t.covariance("nev", kNevCovariance, c);
    t.covariance("hla", "covariance, high side, lateral (right), along hole", hla);
    sd("north", c(0, 0));
    sd("east", c(1, 1));
    sd("vertical", c(2, 2));
    sd("high_side", hla(0, 0));
    sd("lateral", hla(1, 1));
    sd("along_hole", hla(2, 2));
    const propagate::Ellipse e = propagate::ellipse(c.topLeftCorner<2, 2>());
    t.number("semi_major_m", "m", "horizontal ellipse: one standard deviation, major axis", e.semi_major);
    t.number("semi_minor_m", "m", "horizontal ellipse: one standard deviation, minor axis", e.semi_minor);
    t.number("major_azimuth_deg", "deg", "of the major axis, from north, 0 to 180; 0: a circle", e.azimuth / kDegree);
  }
  return t.take();
}

store::Table ellipsoid_table(const survey::Survey& survey, const std::vector<double>& tvd,
                             const propagate::PositionCovariances& result) {
  study::TableRows t("ellipsoid", "position of every station and the axes of its one-sigma ellipsoid");
  const std::vector<Vector3d> positions = survey::minimum_curvature_positions(survey);
  for (std::size_t k = 0; k < survey.stations.size(); ++k) {
    const survey::Station& s = survey.stations[k];
    t.number("md_m", "m", "measured depth", s.md);
    t.number("inclination_deg", "deg", "of the hole", s.inclination / kDegree);
    t.number("azimuth_deg", "deg", "of the hole, true north", study::turn_in_degrees(s.azimuth));
    t.number("north_m", "m", "position relative to the first station, minimum curvature", positions[k].x());
    t.number("east_m", "m", "position relative to the first station, minimum curvature", positions[k].y());
    t.number("tvd_m", "m", "true vertical depth: as listed, or else by minimum curvature", tvd[k]);
    const propagate::Ellipsoid body = propagate::ellipsoid(result.total[k]);
    for (int i = 0; i < 3; ++i) {
      const Vector3d axis = body.axes.col(i);
      const std::string name = fmt::format("axis{}", i + 1);
      t.number(name + "_m", "m", "ellipsoid: one standard deviation, largest first", body.semi_axes[i]);
      t.number(name + "_azimuth_deg", "deg", "of the axis, pointing down", azimuth_deg(axis));
      t.number(name + "_inclination_deg", "deg", "of the axis, from vertical down",
               std::atan2(std::hypot(axis.x(), axis.y()), axis.z()) / kDegree);
    }
  }
  return t.take();
}

store::Table covariance_by_source_table(const survey::Survey& survey, const propagate::PositionCovariances& result) {
  study::TableRows t("covariance_by_source",
                     "position covariance of every station by error source; their sum is the covariance");
  const std::size_t sources = result.sources.size();
  for (std::size_t k = 0; k < survey.stations.size(); ++k)
    for (std::size_t i = 0; i < sources; ++i) {
      t.number("md_m", "m", "measured depth", survey.stations[k].md);
      t.word("source", "code of the error source", result.sources[i]);
      t.covariance("nev", kNevCovariance, result.by_source[k * sources + i]);
    }
  return t.take();
}

store::Table error_terms_table(const study::ToolRuns& legs) {
  study::TableRows t("error_terms", "the error models as they were used, one row a leg and term");
  for (std::size_t l = 0; l < legs.legs.size(); ++l)
    for (const propagate::ErrorTerm& term : legs.legs[l].model.terms) {
      t.count("leg", "number of the survey leg, from 1", l + 1);
      t.number("from_md_m", "m", "measured depth where the leg begins", legs.from_md[l]);
      t.word("model", "error model of the leg", legs.model_names[l]);
      t.word("source", "code of the error source", term.code);
      t.word("function", "weighting function", std::string(term.function->name));
      t.number("magnitude", "1", "one standard deviation, in the unit of this row", term.magnitude);
      t.word("unit", "unit of the magnitude", term.unit);
      t.word("mode", "R random, S systematic, W per well, G global", std::string(1, propagate::mode_letter(term.mode)));
    }
  return t.take();
}

store::Table published_table(const std::vector<PublishedElement>& elements, double margin) {
  study::TableRows t("published",
                     fmt::format("published elements of covariances; agrees: within {:g} of the trace", margin));
  study::write_rows(t, elements, [&](const PublishedElement& p) {
    const double difference = p.own == p.published ? 0 : (p.own - p.published) / p.trace;
    t.number("md_m", "m", "measured depth", p.md);
    t.word("source", "code of the error source, or total", p.source);
    t.word("quantity", "element of the covariance", p.quantity);
    t.number("analytic", "m2", "our value", p.own);
    t.number("published", "m2", "published value", p.published);
    t.number("difference_over_trace", "1", "(analytic - published) / trace of the covariance", difference);
    t.word("verdict", "agrees or differs", std::abs(difference) <= margin ? "agrees" : "differs");
    t.word("expected", "the verdict this row should have", "agrees");
    t.word("note", "where the published value is from", p.origin);
  });
  return t.take();
}

}  // namespace surveymc::studies::position_covariance
