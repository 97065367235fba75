#include "position_covariance_tables.h"

#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "propagate/ellipse.h"
#include "study/table_writer.h"
#include "survey/minimum_curvature.h"

namespace surveymc {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void add_elements(Table& t, const char* axes, const std::string& frame) {
  for (const auto& [i, j] : {std::pair{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}})
    t.columns.push_back(number_column(fmt::format("{}{}_m2", axes[i], axes[j]), "m2", "covariance, " + frame));
}

void write_elements(TableWriter& w, const Matrix3d& c) {
  w << c(0, 0) << c(1, 1) << c(2, 2) << c(0, 1) << c(0, 2) << c(1, 2);
}

void write_deviations(TableWriter& w, const Matrix3d& c) {
  for (int i = 0; i < 3; ++i) w << std::sqrt(std::max(0.0, c(i, i)));
}

/// [0, 360); 0 for a vertical direction.
double azimuth_deg(const Vector3d& v) {
  if (std::hypot(v.x(), v.y()) < 1e-12) return 0;
  const double a = std::atan2(v.y(), v.x()) / kDegree;
  return a < 0 ? a + 360 : a;
}

}  // namespace

Table covariance_table(const Survey& survey, const PositionCovariances& result) {
  Table t{"covariance", "position covariance of every station; standard deviations and axes are one sigma"};
  t.columns = {number_column("md_m", "m", "measured depth")};
  add_elements(t, "nev", "north, east, vertical (down), true north");
  add_elements(t, "hla", "high side, lateral (right), along hole");
  for (const char* d : {"north", "east", "vertical", "high_side", "lateral", "along_hole"})
    t.columns.push_back(number_column(fmt::format("sd_{}_m", d), "m", "one standard deviation"));
  t.columns.push_back(number_column("semi_major_m", "m", "horizontal ellipse: one standard deviation, major axis"));
  t.columns.push_back(number_column("semi_minor_m", "m", "horizontal ellipse: one standard deviation, minor axis"));
  t.columns.push_back(
      number_column("major_azimuth_deg", "deg", "of the major axis, from north, 0 to 180; 0: a circle"));

  TableWriter w(std::move(t));
  for (std::size_t k = 0; k < survey.stations.size(); ++k) {
    const Station& s = survey.stations[k];
    const Matrix3d &c = result.total[k], to_hla = rotation_hla_from_nev(s.inclination, s.azimuth);
    const Matrix3d hla = to_hla * c * to_hla.transpose();
    w << s.md;
    write_elements(w, c);
    write_elements(w, hla);
    write_deviations(w, c);
    write_deviations(w, hla);
    const Ellipse e = ellipse(c.topLeftCorner<2, 2>());
    w << e.semi_major << e.semi_minor << e.azimuth / kDegree;
  }
  return w.take();
}

Table ellipsoid_table(const Survey& survey, const std::vector<double>& tvd, const PositionCovariances& result) {
  Table t{"ellipsoid", "position of every station and the axes of its one-sigma ellipsoid"};
  t.columns = {number_column("md_m", "m", "measured depth"),
               number_column("inclination_deg", "deg", "of the hole"),
               number_column("azimuth_deg", "deg", "of the hole, true north"),
               number_column("north_m", "m", "position relative to the first station, minimum curvature"),
               number_column("east_m", "m", "position relative to the first station, minimum curvature"),
               number_column("tvd_m", "m", "true vertical depth: as listed, or else by minimum curvature")};
  for (const char* axis : {"axis1", "axis2", "axis3"}) {
    t.columns.push_back(
        number_column(fmt::format("{}_m", axis), "m", "ellipsoid: one standard deviation, largest first"));
    t.columns.push_back(number_column(fmt::format("{}_azimuth_deg", axis), "deg", "of the axis, pointing down"));
    t.columns.push_back(
        number_column(fmt::format("{}_inclination_deg", axis), "deg", "of the axis, from vertical down"));
  }

  const std::vector<Vector3d> positions = minimum_curvature_positions(survey);
  TableWriter w(std::move(t));
  for (std::size_t k = 0; k < survey.stations.size(); ++k) {
    const Station& s = survey.stations[k];
    const double azimuth = std::fmod(s.azimuth / kDegree, 360);
    w << s.md << s.inclination / kDegree << (azimuth < 0 ? azimuth + 360 : azimuth) << positions[k].x()
      << positions[k].y() << tvd[k];
    const Ellipsoid body = ellipsoid(result.total[k]);
    for (int i = 0; i < 3; ++i) {
      const Vector3d axis = body.axes.col(i);
      w << body.semi_axes[i] << azimuth_deg(axis) << std::atan2(std::hypot(axis.x(), axis.y()), axis.z()) / kDegree;
    }
  }
  return w.take();
}

Table covariance_by_source_table(const Survey& survey, const PositionCovariances& result) {
  Table t{"covariance_by_source", "position covariance of every station by error source; their sum is the covariance"};
  t.columns = {number_column("md_m", "m", "measured depth"), word_column("source", "code of the error source")};
  add_elements(t, "nev", "north, east, vertical (down), true north");
  TableWriter w(std::move(t));
  const std::size_t sources = result.sources.size();
  for (std::size_t k = 0; k < survey.stations.size(); ++k)
    for (std::size_t i = 0; i < sources; ++i) {
      w << survey.stations[k].md << result.sources[i];
      write_elements(w, result.by_source[k * sources + i]);
    }
  return w.take();
}

Table error_terms_table(const SurveyLegs& legs) {
  Table t{"error_terms", "the error models as they were used, one row a leg and term"};
  t.columns = {count_column("leg", "number of the survey leg, from 1"),
               number_column("from_md_m", "m", "measured depth where the leg begins"),
               word_column("model", "error model of the leg"),
               word_column("source", "code of the error source"),
               word_column("function", "weighting function"),
               number_column("magnitude", "1", "one standard deviation, in the unit of this row"),
               word_column("unit", "unit of the magnitude"),
               word_column("mode", "R random, S systematic, W per well, G global")};
  TableWriter w(std::move(t));
  for (std::size_t l = 0; l < legs.legs.size(); ++l)
    for (const ErrorTerm& term : legs.legs[l].model.terms)
      w << static_cast<std::int64_t>(l + 1) << legs.from_md[l] << legs.model_names[l] << term.code
        << std::string(term.function->name) << term.magnitude << term.unit << std::string(1, mode_letter(term.mode));
  return w.take();
}

Table published_table(const std::vector<PublishedElement>& elements, double margin) {
  Table t{"published", fmt::format("published elements of covariances; agrees: within {:g} of the trace", margin)};
  t.columns = {number_column("md_m", "m", "measured depth"),
               word_column("source", "code of the error source, or total"),
               word_column("quantity", "element of the covariance"),
               number_column("analytic", "m2", "our value"),
               number_column("published", "m2", "published value"),
               number_column("difference_over_trace", "1", "(analytic - published) / trace of the covariance"),
               word_column("verdict", "agrees or differs"),
               word_column("expected", "the verdict this row should have"),
               word_column("note", "where the published value is from")};
  TableWriter w(std::move(t));
  for (const PublishedElement& p : elements) {
    const double difference = p.own == p.published ? 0 : (p.own - p.published) / p.trace;
    w << p.md << p.source << p.quantity << p.own << p.published << difference
      << std::string(std::abs(difference) <= margin ? "agrees" : "differs") << std::string("agrees") << p.origin;
  }
  return w.take();
}

}  // namespace surveymc
