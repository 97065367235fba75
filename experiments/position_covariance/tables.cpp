#include "position_covariance/tables.h"

#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "base/standard_deviation.h"
#include "base/units.h"
#include "compare/table_rows.h"
#include "propagate/ellipse.h"
#include "store/result_file.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::position_covariance {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr const char* kNevCovariance = "covariance, north, east, vertical (down), true north";

/// [0, 360); 0 for a vertical direction, NaN of one that is not there.
double azimuth_deg(const Vector3d& v) {
  if (std::hypot(v.x(), v.y()) < 1e-12) return 0;
  const double a = std::atan2(v.y(), v.x()) / kDegree;
  return a < 0 ? a + 360 : a;
}

}  // namespace

store::Table covariance_table(const survey::Survey& survey, const propagate::ToolCovariances& result,
                              const std::function<void(std::size_t)>& at_station) {
  compare::TableRows t("covariance", "position covariance of every station; standard deviations and axes are one sigma",
                       survey.stations.size());
  for (std::size_t k = 0; k < survey.stations.size(); ++k) {
    const survey::Station& s = survey.stations[k];
    const Matrix3d &c = result.total[k], to_hla = survey::rotation_hla_from_nev(s.inclination, s.azimuth);
    const Matrix3d hla = to_hla * c * to_hla.transpose();
    const auto sd = [&](const char* name, double variance) {
      t.number(name, "m", "one standard deviation", standard_deviation(variance));
    };
    t.number("md_m", "m", "measured depth", s.md);
    t.covariance("nev", kNevCovariance, c);
    t.covariance("hla", "covariance, high side, lateral (right), along hole", hla);
    sd("sd_north_m", c(0, 0));
    sd("sd_east_m", c(1, 1));
    sd("sd_vertical_m", c(2, 2));
    sd("sd_high_side_m", hla(0, 0));
    sd("sd_lateral_m", hla(1, 1));
    sd("sd_along_hole_m", hla(2, 2));
    const propagate::Ellipse e = propagate::ellipse(c.topLeftCorner<2, 2>());
    t.number("semi_major_m", "m", "horizontal ellipse: one standard deviation, major axis", e.semi_major);
    t.number("semi_minor_m", "m", "horizontal ellipse: one standard deviation, minor axis", e.semi_minor);
    t.number("major_azimuth_deg", "deg", "of the major axis, from north, 0 to 180; 0: a circle", e.azimuth / kDegree);
    at_station(k + 1);
  }
  return t.take();
}

store::Table ellipsoid_table(const survey::Survey& survey, const std::vector<double>& tvd,
                             const std::vector<Matrix3d>& covariances,
                             const std::function<void(std::size_t)>& at_station) {
  compare::TableRows t("ellipsoid", "position of every station and the axes of its one-sigma ellipsoid",
                       survey.stations.size());
  const std::vector<Vector3d> positions = survey::minimum_curvature_positions(survey);
  constexpr std::array<std::array<const char*, 3>, 3> kAxes{
      {{"axis1_m", "axis1_azimuth_deg", "axis1_inclination_deg"},
       {"axis2_m", "axis2_azimuth_deg", "axis2_inclination_deg"},
       {"axis3_m", "axis3_azimuth_deg", "axis3_inclination_deg"}}};
  for (std::size_t k = 0; k < survey.stations.size(); ++k) {
    const survey::Station& s = survey.stations[k];
    t.number("md_m", "m", "measured depth", s.md);
    t.number("inclination_deg", "deg", "of the hole", s.inclination / kDegree);
    t.number("azimuth_deg", "deg", "of the hole, true north", compare::turn_in_degrees(s.azimuth));
    t.number("north_m", "m", "position relative to the first station, minimum curvature", positions[k].x());
    t.number("east_m", "m", "position relative to the first station, minimum curvature", positions[k].y());
    t.number("tvd_m", "m", "true vertical depth: as listed, or else by minimum curvature", tvd[k]);
    const propagate::Ellipsoid body = propagate::ellipsoid(covariances[k]);
    for (int i = 0; i < 3; ++i) {
      const Vector3d axis = body.axes.col(i);
      const auto& [length, azimuth, inclination] = kAxes[static_cast<std::size_t>(i)];
      t.number(length, "m", "ellipsoid: one standard deviation, largest first", body.semi_axes[i]);
      t.number(azimuth, "deg", "of the axis, pointing down", azimuth_deg(axis));
      t.number(inclination, "deg", "of the axis, from vertical down",
               std::atan2(std::hypot(axis.x(), axis.y()), axis.z()) / kDegree);
    }
    at_station(k + 1);
  }
  return t.take();
}

namespace {

/// The table of so many rows, but for its covariances.
store::Table by_source_columns(const survey::Survey& survey, const std::vector<std::string>& sources, std::size_t rows,
                               bool of_all) {
  const std::size_t n = survey.stations.size();
  compare::TableRows one("covariance_by_source",
                         of_all ? "position covariance of every station by error source; their sum is the covariance"
                                : "position covariance of the last station by error source");
  one.number("md_m", "m", "measured depth", 0);
  one.word("source", "code of the error source", "");
  one.covariance("nev", kNevCovariance, Matrix3d::Zero());
  store::Table t = one.take();  // of 10,000 stations and 35 sources these columns are large: they are moved, not copied

  const std::size_t first = of_all ? 0 : n - 1;
  std::vector<double> md(rows == 0 ? 0 : n - first);
  for (std::size_t k = 0; k < md.size(); ++k) md[k] = survey.stations[first + k].md;
  t.columns[0].on_disk = std::make_shared<store::MadeValues>(
      md.size() * sources.size(), [md, n = sources.size()](std::size_t at, std::size_t count) {
        std::vector<double> out(count);
        for (std::size_t i = 0; i < count; ++i) out[i] = md[(at + i) / n];
        return out;
      });
  t.columns[1].on_disk =
      std::make_shared<store::MadeValues>(md.size() * sources.size(), [sources](std::size_t at, std::size_t count) {
        std::vector<std::string> out(count);
        for (std::size_t i = 0; i < count; ++i) out[i] = sources[(at + i) % sources.size()];
        return out;
      });
  if (rows <= store::kMostHeldRows)
    for (std::size_t c = 0; c < 2; ++c)
      t.columns[c].values = std::exchange(t.columns[c].on_disk, nullptr)->read(0, rows);
  else
    for (std::size_t c = 0; c < 2; ++c) std::visit([](auto& row) { row.clear(); }, t.columns[c].values);
  for (std::size_t c = 2; c < t.columns.size(); ++c) t.columns[c].values = std::vector<double>();
  return t;
}

}  // namespace

store::Table covariance_by_source_table(const survey::Survey& survey, propagate::ToolCovariances& result,
                                        propagate::SourceDetail detail) {
  store::Table t =
      by_source_columns(survey, result.sources, result.by_source.size(), detail == propagate::SourceDetail::all);
  for (std::size_t c = 2; c < t.columns.size(); ++c) t.columns[c].values = std::move(result.by_source.elements[c - 2]);
  return t;
}

store::Table tool_codes_table(const scenario::ToolRuns& tools) {
  compare::TableRows t("tool_codes", "the error models of the survey legs");
  for (std::size_t l = 0; l < tools.runs.size(); ++l) {
    const error_model::Model& m = *tools.runs[l].model;
    t.count("leg", "number of the survey leg, from 1", l + 1);
    t.number("from_md_m", "m", "measured depth where the leg begins", tools.from_md[l]);
    t.word("model", "error model of the leg", tools.model_names[l]);
    t.word("title", "of the model", m.title);
    t.word("prefix", "OWSG's prefix; floating-rig twins share it", m.prefix);
    t.word("revision", "of the model", m.revision);
    t.word("catalogue", "file that the model is from", m.catalogue);
    t.count("terms", "number of error sources", m.terms.size());
    t.number("inclination_min_deg", "deg", "least inclination at which the model holds", m.inclination_min / kDegree);
    t.number("inclination_max_deg", "deg", "largest inclination at which the model holds", m.inclination_max / kDegree);
    t.number("east_west_exclusion_deg", "deg", "it does not hold within this angle of horizontal magnetic east or west",
             m.east_west_exclusion / kDegree);
    t.word("note", "what the model's author says", m.note);
  }
  return t.take();
}

store::Table error_terms_table(const scenario::ToolRuns& tools) {
  struct Row {
    std::size_t leg;
    const error_model::Term* term;
  };
  std::vector<Row> rows;
  for (std::size_t l = 0; l < tools.runs.size(); ++l)
    for (const error_model::Term& term : tools.runs[l].model->terms) rows.push_back({l, &term});
  compare::TableRows t("error_terms", "the error models as they were used, one row a leg and term");
  const error_model::Term none{"", std::make_shared<const error_model::Function>(), 0, "", 0, {}};
  compare::write_rows(t, rows, [&](const Row& r) {
    const error_model::Term& term = r.term ? *r.term : none;
    const error_model::Function& f = *term.function;
    t.count("leg", "number of the survey leg, from 1", r.leg + 1);
    t.number("from_md_m", "m", "measured depth where the leg begins", tools.from_md[r.leg]);
    t.word("model", "error model of the leg", tools.model_names[r.leg]);
    t.word("source", "code of the error source", term.code);
    t.word("function", "weighting function", f.name);
    t.number("magnitude", "1", "one standard deviation, in the unit of this row", term.magnitude);
    t.word("unit", "unit of the magnitude", term.unit);
    t.word("mode", "R random, S systematic, W per well, G global", std::string(1, mode_letter(term.mode)));
    t.word("kind", "station, course, stationary or continuous", error_model::kind_name(f.kind));
    t.word("depth", "formula of the effect on depth, m", f.depth.text);
    t.word("inclination", "formula of the effect on inclination, rad", f.inclination.text);
    t.word("azimuth_or_lateral", "formula of the effect on azimuth, or (\"lateral:\") of sinI times it, rad",
           f.lateral.empty() ? f.azimuth.text : "lateral: " + f.lateral.text);
    t.word("file", "file that the function is from", f.file);
  });
  return t.take();
}

store::Table gyro_table(const survey::Survey& survey, const scenario::ToolRuns& tools,
                        const propagate::ToolCovariances& result) {
  struct Row {
    std::size_t leg;
    propagate::GyroStretch stretch;
  };
  std::vector<Row> rows;
  for (std::size_t l = 0; l < result.gyro.size(); ++l)
    for (const propagate::GyroStretch& s : result.gyro[l]) rows.push_back({l, s});
  compare::TableRows t(
      "gyro", "sections of hybrid gyros; the azimuth at initialisation is the one listed at the station before");
  compare::write_rows(t, rows, [&](const Row& r) {
    const propagate::GyroStretch& s = r.stretch;
    t.count("leg", "number of the survey leg, from 1", r.leg + 1);
    t.word("model", "error model of the leg", tools.model_names[r.leg]);
    t.count("section", "number of the section in the leg, from 1", s.section + 1);
    t.word("mode", "stationary: a compass at every station; continuous: since its initialisation",
           s.is_continuous ? "continuous" : "stationary");
    t.number("from_md_m", "m", "measured depth of the first station", survey.stations[s.first].md);
    t.number("to_md_m", "m", "measured depth of the last station", survey.stations[s.end > 0 ? s.end - 1 : 0].md);
    t.number("initialised_at_deg", "deg", "inclination at which the stationary terms keep their values",
             s.is_continuous ? s.initialised_inclination / kDegree : kNaN);
    t.number("azimuth_used_deg", "deg", "azimuth (true) at which they do",
             s.is_continuous ? compare::turn_in_degrees(s.initialised_azimuth) : kNaN);
    t.word("azimuth_is_of_vertical_station", "yes: the survey lists it for a vertical station, where it means nothing",
           !s.is_continuous                   ? ""
           : s.azimuth_is_of_vertical_station ? "yes"
                                              : "no");
  });
  return t.take();
}

store::Table published_table(const std::vector<PublishedElement>& elements, double margin) {
  compare::TableRows t("published",
                       fmt::format("published elements of covariances; agrees: within {:g} of the trace", margin));
  compare::write_rows(t, elements, [&](const PublishedElement& p) {
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
