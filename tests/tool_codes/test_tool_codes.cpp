/// The shipped tool codes and the gyro rules against published and independently computed figures.
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include <catch2/catch.hpp>

#include "base/units.h"
#include "config/error_model_file.h"
#include "propagate/tool_covariance.h"
#include "survey/minimum_curvature.h"
#include "tools.h"

using namespace surveymc;
using namespace surveymc::config;
using namespace surveymc::propagate;
using namespace surveymc::survey;
using Eigen::Matrix3d;

namespace {

std::vector<SharedModel> from_text(const std::string& text, const std::string& functions = "") {
  std::vector<InputText> files{{"tool.toml", text}, {"functions.toml", functions}};
  for (const ShippedModel& m : shipped_models())
    if (text.find("extends = '" + m.name + "'") != std::string::npos) files.push_back(shipped_document(m));
  Config config = Config::from_text("experiment = 'x'\nmodel = 'tool.toml'\n", "c.toml", {}, files);
  return read_error_models(config.reader(0).toml("model", ""), "tool");
}

std::vector<std::vector<std::string>> rows_of(const std::string& csv) {
  std::vector<std::vector<std::string>> out;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    out.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) out.back().push_back(cell);
  }
  out.erase(out.begin());
  return out;
}
std::vector<std::vector<std::string>> data(const std::string& name) {
  return rows_of(test::project_file("tests/tool_codes/data/" + name));
}

using Well = test::IscwsaWell;
using test::iscwsa_well;
using test::shipped;

ToolCovariances covariances(const Well& w, const SharedModel& model, SourceDetail detail = SourceDetail::none) {
  return tool_covariances(w.survey, w.tvd, {{1, model}}, w.field, w.latitude, detail);
}

std::size_t station_at(const Well& w, double md) {
  for (std::size_t k = 0; k < w.survey.stations.size(); ++k)
    if (std::abs(w.survey.stations[k].md - md) < 1e-6) return k;
  FAIL("no station at " << md);
  return 0;
}

double largest(const Matrix3d& m) { return m.cwiseAbs().maxCoeff(); }

}  // namespace

TEST_CASE("The 101 tool codes are all there, each name once") {
  std::map<std::string, int> of_catalogue;
  std::set<std::string> names;
  std::size_t terms = 0;
  std::set<std::string> codes, functions;
  for (const ShippedModel& s : shipped_models()) {
    CAPTURE(s.name);
    ++of_catalogue[s.catalogue];
    CHECK(names.insert(s.name).second);
    const SharedModel m = shipped(s.name);
    CHECK(shipped(s.catalogue + "/" + s.name)->terms.size() == m->terms.size());
    if (!s.catalogue.starts_with("owsg")) continue;
    CHECK(m->name == s.name);
    terms += m->terms.size();
    for (const auto& t : m->terms) {
      codes.insert(t.code);
      functions.insert(t.function->name);
    }
  }
  CHECK(of_catalogue["owsg_a_rev5.1"] == 59);
  CHECK(of_catalogue["owsg_b_rev5.1"] == 42);
  CHECK(terms == 3095);
  CHECK(codes.size() == 96);
  CHECK(functions.size() == 59);
  CHECK(shipped_functions().size() == 59);
  CHECK(shipped("ZERO-ERROR")->terms.empty());
}

TEST_CASE("A term code has one mode and one function in all shipped tool codes") {
  std::map<std::string, std::pair<error_model::PropagationMode, std::string>> known;
  for (const ShippedModel& s : shipped_models()) {
    if (!s.catalogue.starts_with("owsg")) continue;
    const SharedModel m = shipped(s.name);
    for (const auto& t : m->terms) {
      const std::pair here(t.mode, t.function->name);
      CAPTURE(s.name, t.code);
      CHECK(known.try_emplace(t.code, here).first->second == here);
    }
  }
}

TEST_CASE("All 101 tool codes on ISCWSA well 1 are what an independent program gives") {
  const Well w = iscwsa_well(1);
  std::map<std::string, ToolCovariances> done;
  int compared = 0;
  double worst = 0;
  for (const auto& row : data("expected_well1.csv")) {
    const std::string& name = row[1];
    if (!done.contains(name)) done[name] = covariances(w, shipped(name));
    const Matrix3d& c = done[name].total[station_at(w, std::stod(row[2]))];
    const std::array<double, 6> own{c(0, 0), c(1, 1), c(2, 2), c(0, 1), c(0, 2), c(1, 2)};
    const double trace = std::stod(row[3]) + std::stod(row[4]) + std::stod(row[5]);
    for (std::size_t i = 0; i < 6; ++i) {
      CAPTURE(name, row[2], i, own[i], row[3 + i]);
      const double d = std::abs(own[i] - std::stod(row[3 + i]));
      CHECK(d <= 1e-9 * trace);
      if (trace > 0) worst = std::max(worst, d / trace);
    }
    ++compared;
  }
  CHECK(compared == 303);
  CHECK(worst <= 1e-11);  // the figures have 12 digits
}

TEST_CASE("MWD+SRGM is the ISCWSA MWD model Rev 5.10, at every station and by source") {
  for (const int number : {1, 2}) {
    const Well w = iscwsa_well(number);
    const ToolCovariances a = covariances(w, shipped("MWD+SRGM"), SourceDetail::all),
                          b = covariances(w, shipped("iscwsa_mwd_rev5.10"), SourceDetail::all);
    REQUIRE(a.sources == b.sources);
    for (std::size_t k = 1; k < a.total.size(); ++k)
      CHECK(largest(a.total[k] - b.total[k]) <= 1e-13 * b.total[k].trace());
    for (std::size_t i = 0; i < a.by_source.size(); ++i)
      CHECK(largest(a.by_source[i] - b.by_source[i]) <= 1e-13 * b.by_source[i].trace());
  }
}

TEST_CASE("MWD+IFR1 gives every printed digit of the ISCWSA correlation diagnostics") {
  const std::string with_their_magnitudes =
      "[[model]]\nname = 'theirs'\nextends = 'MWD+IFR1'\nterms = [\n"
      "  { code = 'DBH-U', function = 'DBH', magnitude = 1271.12, unit = 'deg.nT', mode = 'W' },\n"
      "  { code = 'DBH-CI', function = 'DBH', magnitude = 712.32, unit = 'deg.nT', mode = 'G' } ]\n";
  const SharedModel model = from_text(with_their_magnitudes).back();
  std::map<std::string, Well> wells;
  for (const auto& row : data("correlation_surveys.csv")) {
    Well& w = wells[row[0]];
    w.survey.stations.push_back({std::stod(row[1]), std::stod(row[2]) * kDegree, std::stod(row[3]) * kDegree, 0});
    w.tvd.push_back(std::stod(row[4]));
    w.field = {9.80665, 50000, 70 * kDegree, 0, 0};
    w.latitude = 60 * kDegree;
  }
  std::map<std::string, ToolCovariances> done;
  for (const auto& [name, w] : wells) done[name] = covariances(w, model, SourceDetail::all);
  int compared = 0;
  for (const auto& row : data("correlation_mwd_ifr1.csv")) {
    const Well& w = wells.at(row[0]);
    const ToolCovariances& own = done.at(row[0]);
    const std::size_t k = station_at(w, std::stod(row[1]));
    Matrix3d c = own.total[k];
    if (row[2] != "total") {
      const auto at = std::find(own.sources.begin(), own.sources.end(), row[2]);
      CAPTURE(row[2]);
      REQUIRE(at != own.sources.end());
      c = own.by_source[k * own.sources.size() + static_cast<std::size_t>(at - own.sources.begin())];
    }
    const std::array<double, 6> ours{c(0, 0), c(1, 1), c(2, 2), c(0, 1), c(0, 2), c(1, 2)};
    for (std::size_t i = 0; i < 6; ++i) {
      CAPTURE(row[0], row[1], row[2], i);
      CHECK(std::abs(ours[i] - std::stod(row[3 + i])) <= 6e-5);  // four decimals
    }
    ++compared;
  }
  CHECK(compared == 457);
  // With the rounded magnitudes of the tool code.
  const Well& reference = wells.at("reference");
  const Matrix3d rounded = covariances(reference, shipped("MWD+IFR1")).total[station_at(reference, 2940)];
  CHECK(std::abs(rounded(1, 1) - 76.8994) <= 6e-5);
}

namespace {

/// Linear between stations, as the source has it.
Matrix3d at_depth(const Well& w, const ToolCovariances& c, double md) {
  const auto& s = w.survey.stations;
  for (std::size_t k = 1; k < s.size(); ++k)
    if (md <= s[k].md + 1e-9) {
      const double part = (md - s[k - 1].md) / (s[k].md - s[k - 1].md);
      return c.total[k - 1] + part * (c.total[k] - c.total[k - 1]);
    }
  FAIL("beyond the well");
  return {};
}

}  // namespace

TEST_CASE("The gyro examples of SPE 90408 have the published covariances") {
  const auto models = from_text(test::project_file("tests/tool_codes/data/spe90408_examples.toml"),
                                test::project_file("configs/error_models/functions.toml"));
  std::map<std::string, SharedModel> by_name;
  for (const auto& m : models) by_name[m->name] = m;
  std::map<std::string, int> inside, all;
  for (const int number : {1, 2}) {
    Well w = iscwsa_well(number);
    // Azimuths of well 2 are grid, and so are the results; the convergence is not published, 1.0 to 1.75 deg do.
    const double convergence = number == 2 ? 1.25 * kDegree : 0;
    for (Station& s : w.survey.stations) s.azimuth += convergence;
    Matrix3d to_grid = Matrix3d::Identity();
    to_grid(0, 0) = to_grid(1, 1) = std::cos(convergence);
    to_grid(0, 1) = std::sin(convergence);
    to_grid(1, 0) = -std::sin(convergence);
    const std::string name = fmt::format("well{}", number);
    for (const auto& row : data("appendix_e.csv")) {
      if (row[0] != name) continue;
      const double unit = row[3] == "ft" ? kFoot : 1;
      const Matrix3d c = to_grid * at_depth(w, covariances(w, by_name.at(row[1])), unit * std::stod(row[2])) *
                         to_grid.transpose() / (unit * unit);
      const std::array<double, 6> ours{c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)};
      for (std::size_t i = 0; i < 6; ++i) {
        const double theirs = std::stod(row[4 + i]), tolerance = std::abs(theirs) < 200 ? 2 : 0.01 * std::abs(theirs);
        CAPTURE(name, row[1], row[2], i, ours[i], theirs);
        CHECK(std::abs(ours[i] - theirs) <= tolerance);
        ++all[name];
        inside[name] += std::abs(ours[i] - theirs) <= tolerance;
      }
    }
  }
  CHECK(all["well1"] == 156);
  CHECK(all["well2"] == 180);
  CHECK(inside["well1"] == 156);
  CHECK(inside["well2"] == 180);
}

TEST_CASE("Straight holes: standard deviations across the hole by tool code") {
  struct Expected {
    double inclination, azimuth;
    const char* model;
    double high_side, lateral;
  };
  const std::vector<Expected> all{
      {30, 0, "MWD+SRGM", 2.9298, 4.5070},         {30, 0, "MWD+IFR1+SAG+MS", 1.6496, 2.1493},
      {30, 0, "MWD+IFR2+AX+SAG", 1.6496, 2.7408},  {30, 0, "GYRO-NS", 2.9007, 7.7039},
      {30, 0, "GYRO-NS-CT", 1.5974, 13.4663},      {60, 90, "MWD+SRGM", 3.4127, 12.5091},
      {60, 90, "MWD+IFR1+SAG+MS", 1.9828, 5.7683}, {60, 90, "MWD+IFR2+AX+SAG", 1.9828, 10.5208},
      {60, 90, "GYRO-NS", 3.3896, 108.9421},       {60, 90, "GYRO-NS-CT", 1.9427, 29.1506},
      {85, 45, "MWD+SRGM", 3.5588, 13.1975},       {85, 45, "MWD+IFR1+SAG+MS", 2.0953, 6.0354},
      {85, 45, "MWD+IFR2+AX+SAG", 2.0953, 9.2060}, {85, 45, "GYRO-NS", 3.5460, 583.3905},
      {85, 45, "GYRO-NS-CT", 2.0735, 30.2334}};
  for (const Expected& e : all) {
    Well w = iscwsa_well(1);
    w.survey.stations.clear();
    for (int k = 0; k <= 30; ++k)
      w.survey.stations.push_back({30.0 * k, e.inclination * kDegree, e.azimuth * kDegree, 0});
    w.tvd = true_vertical_depths(w.survey);
    const Matrix3d r = rotation_hla_from_nev(e.inclination * kDegree, e.azimuth * kDegree),
                   c = r * covariances(w, shipped(e.model)).total.back() * r.transpose();
    CAPTURE(e.model, e.inclination, e.azimuth);
    CHECK(std::abs(std::sqrt(c(0, 0)) - e.high_side) <= 5.01e-5);
    CHECK(std::abs(std::sqrt(c(1, 1)) - e.lateral) <= 5.01e-5);
  }
}

TEST_CASE("Azimuth and vertical formulas give what the closed forms give") {
  const std::string azimuth_form = test::project_file("tests/tool_codes/data/functions_azimuth_form.toml");
  double worst = 0;
  for (const char* name : {"MWD+SRGM", "MWD+SRGM+AX", "UNKNOWN", "CB_Film_GMS", "INC-ONLY"}) {
    if (find_shipped_model(name) == nullptr) continue;
    const SharedModel closed = shipped(name);
    const SharedModel printed =
        from_text(azimuth_form +
                  fmt::format("\n[[model]]\nname = 'printed'\nextends = '{}'\nterms = [\n{}]\n", name,
                              [&] {
                                std::string terms;
                                for (const auto& t : closed->terms)
                                  terms += fmt::format(
                                      "{{ code = '{}', function = '{}', magnitude = {}, unit = '{}', mode = '{}' }},\n",
                                      t.code, t.function->name, format_number(t.magnitude), t.unit,
                                      error_model::mode_letter(t.mode));
                                return terms;
                              }()))
            .back();
    for (const int number : {1, 2}) {
      Well w = iscwsa_well(number);
      w.survey.stations[5].azimuth = 1;  // of a vertical station: means nothing
      const ToolCovariances a = covariances(w, closed), b = covariances(w, printed);
      for (std::size_t k = 1; k < a.total.size(); ++k) {
        CAPTURE(name, number, k);
        if (std::isnan(a.total[k](0, 0))) {  // a gyrocompass beyond 89.9 deg
          CHECK(std::isnan(b.total[k](0, 0)));
          continue;
        }
        const double d = largest(a.total[k] - b.total[k]) / a.total[k].trace();
        CHECK(d <= 1e-14);
        worst = std::max(worst, d);
      }
    }
  }
  CHECK(worst > 0);
}

TEST_CASE("A model as text reads back to the same model") {
  for (const char* name : {"MWD+IFR1", "GYRO-NS-CT", "GYRO-MWD", "MWD+SRGM+AX", "ZERO-ERROR", "CB_Film_GMS_Fl"}) {
    if (find_shipped_model(name) == nullptr) continue;
    CAPTURE(name);
    const SharedModel a = shipped(name), b = from_text(model_text(*a)).back();
    CHECK(model_text(*b) == model_text(*a));
    const Well w = iscwsa_well(1);
    const ToolCovariances x = covariances(w, a), y = covariances(w, b);
    for (std::size_t k = 1; k < x.total.size(); ++k)
      CHECK((std::isnan(x.total[k](0, 0)) ? std::isnan(y.total[k](0, 0))
                                          : largest(x.total[k] - y.total[k]) <= 1e-15 * x.total[k].trace()));
  }
}
