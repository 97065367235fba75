#include "scenario/reference_laws.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <mutex>

#include <fmt/format.h>

namespace surveymc::scenario {
namespace {

using random::LawKind;
using random::ReferenceElement;

random::LawOf read_law(config::ConfigReader& c, const std::string& key) {
  random::LawOf law;
  const std::string name =
      c.choice(key + ".law", random::law_names(),
               "law of these errors of the reference, of the same variance: 'normal', 'laplace', 'student', 'nig' "
               "(normal inverse Gaussian), 'two_point' (some errors are larger), 'asymmetric_nig'");
  law.kind = static_cast<LawKind>(std::find(random::law_names().begin(), random::law_names().end(), name) -
                                  random::law_names().begin());
  switch (law.kind) {
    case LawKind::normal:
    case LawKind::laplace:
      break;
    case LawKind::student:
      law.degrees = c.number(key + ".degrees", config::Range{2, 1000, true, false},
                             "degrees of freedom of 'student'; no kurtosis up to 4");
      break;
    case LawKind::asymmetric_nig:
      law.skew = c.number(key + ".skew", config::Range::closed(-10, 10),
                          "of 'asymmetric_nig': shift of the mean by V less 1, in sd of the normal");
      [[fallthrough]];
    case LawKind::nig:
      law.shape = c.number(key + ".shape", config::Range::closed(0.02, 1000),
                           "shape of the inverse Gaussian V of 'nig' and 'asymmetric_nig': excess kurtosis is 3 over "
                           "it");
      break;
    case LawKind::two_point:
      law.share = c.number(key + ".share", config::Range::open(0, 1), "of 'two_point': share of the larger errors");
      law.ratio = c.number(key + ".ratio", config::Range::closed(0.01, 100),
                           "of 'two_point': sd of these over that of the others");
      break;
  }
  return law;
}

/// A law and what a reader says of it.
struct KnownLaw {
  std::shared_ptr<const random::MixingLaw> law;
  std::array<double, 3> sd;       ///< of a size by each of random::SizeMeaning
  std::array<double, 3> outside;  ///< beyond 2, 3, 3.5 sd
};

/// Every point of a sweep reads its laws, which are mostly those of the point before, and a law's table of quantiles
/// takes milliseconds: the last ones are kept.
KnownLaw known_law(const random::LawOf& of) {
  constexpr std::size_t kMost = 64;
  static std::mutex mutex;
  static std::deque<KnownLaw> known;
  const std::lock_guard lock(mutex);
  for (const KnownLaw& k : known)
    if (k.law->law() == of) return k;
  const auto law = std::make_shared<const random::MixingLaw>(of);
  using random::SizeMeaning;
  const auto sd = [&](SizeMeaning size) { return random::sd_of_size(*law, size); };
  known.push_back({law,
                   {sd(SizeMeaning::sd), sd(SizeMeaning::ci68), sd(SizeMeaning::ci95)},
                   {law->outside(2), law->outside(3), law->outside(3.5)}});
  if (known.size() > kMost) known.pop_front();
  return known.back();
}

std::string numbers_of(const random::LawOf& law) {
  switch (law.kind) {
    case LawKind::student:
      return fmt::format(" of {:g} degrees", law.degrees);
    case LawKind::nig:
      return fmt::format(" of shape {:g}", law.shape);
    case LawKind::asymmetric_nig:
      return fmt::format(" of shape {:g}, skew {:g}", law.shape, law.skew);
    case LawKind::two_point:
      return fmt::format(", {:g} % at {:g} sd", 100 * law.share, law.ratio);
    default:
      return "";
  }
}

}  // namespace

random::ReferenceLaws read_reference_laws(config::ConfigReader& c, const ReferenceDraws& draws) {
  random::ReferenceLaws laws;
  std::vector<std::size_t> given;
  for (std::size_t e = 0; e < random::reference_elements().size(); ++e) {
    if (!draws.declination && static_cast<ReferenceElement>(e) == ReferenceElement::declination) continue;
    const std::string key = "reference_law." + random::reference_elements()[e];
    if (!c.has(key + ".law")) {
      c.require(!c.has(key), key, "has no law");
      continue;
    }
    const random::LawOf of = read_law(c, key);
    const std::string size =
        c.choice(key + ".size", random::size_names(),
                 "what the tabulated size of these errors is: their 'sd'; 'ci68', half of the interval that has 68.3 "
                 "%; 'ci95', a quarter of that of 95.4 %");
    c.require(draws.sizes || size == "sd", key + ".size",
              "must be \"sd\" here: the covariances are those of the model's own sizes");
    const auto meaning = static_cast<random::SizeMeaning>(
        std::find(random::size_names().begin(), random::size_names().end(), size) - random::size_names().begin());
    if (of.kind == LawKind::normal) continue;
    const auto [law, sd, outside] = known_law(of);
    auto& element = laws.elements[e];
    element = {law, sd[static_cast<std::size_t>(meaning)], size};
    given.push_back(e);
    c.note(fmt::format(
        "{}: {}{}: sd {:.4g} of the tabulated size, which is {}; excess kurtosis {:.3g}; beyond 2, 3, "
        "3.5 sd {:.3g}, {:.3g}, {:.3g} %",
        random::reference_elements()[e], random::law_names()[static_cast<std::size_t>(of.kind)], numbers_of(of),
        element.sd, size, law->excess_kurtosis(), 100 * outside[0], 100 * outside[1], 100 * outside[2]));
    constexpr double kMostKurtosis = 1000;
    if (draws.sizes && !(law->excess_kurtosis() <= kMostKurtosis))
      c.warn(
          key + ".law",
          fmt::format("has an excess kurtosis of {:.3g}: intervals and verdicts of sds by trials fail, as few trials "
                      "make up the variance",
                      law->excess_kurtosis()),
          "believe its tails and quantiles; or take a law that has a kurtosis (student: more than 4 degrees)");
  }
  if (given.empty()) return laws;
  if (draws.modes && c.has("reference_law.modes")) {
    const std::vector<std::string> modes =
        c.texts("reference_law.modes", "errors of these modes have the laws, of \"G\", \"W\", \"R\"; without it all");
    for (const std::string& m : modes)
      c.require(m == "G" || m == "W" || m == "R", "reference_law.modes",
                fmt::format("\"{}\": must be of \"G\", \"W\", \"R\"", m));
    const auto has = [&](const char* m) { return std::find(modes.begin(), modes.end(), m) != modes.end(); };
    laws.global = has("G");
    laws.well = has("W");
    laws.random = has("R");
  }
  laws.shared_mixing = c.boolean("reference_law.shared_mixing",
                                 "all elements have one V, as in a storm, which is large in all of them", false);
  if (draws.terms)
    laws.each_term =
        c.boolean("reference_law.each_term",
                  "every term has a V of its own; else those of one element share it: measured laws are of "
                  "their sum",
                  false);
  c.require(!laws.shared_mixing || !laws.each_term, "reference_law.each_term", "not together with shared_mixing");
  for (const std::size_t e : given) {
    const std::string key = "reference_law." + random::reference_elements()[e] + ".law";
    const random::LawOf& of = laws.elements[e].law->law();
    c.require(!laws.shared_mixing || of == laws.elements[given.front()].law->law(), key,
              "with shared_mixing all elements have one law");
    // A shift that several draws share would correlate them: the covariance would not be that of the terms.
    c.require(laws.elements[e].law->is_symmetric() || ((laws.each_term || !draws.terms) && !laws.shared_mixing), key,
              draws.terms ? "needs each_term = true: a V that terms share would correlate them by its shift"
                          : "not together with shared_mixing, whose shift would correlate the elements");
  }
  return laws;
}

void warn_of_idle_laws(config::ConfigReader& c, const random::ReferenceLaws& laws,
                       const std::vector<const ToolRuns*>& tools, bool with_random) {
  using enum error_model::PropagationMode;
  const auto has_law = [&](const error_model::Term& t) {
    return (t.mode == global && laws.global) || (t.mode == well && laws.well) ||
           (t.mode == random && laws.random && with_random);
  };
  for (std::size_t e = 0; e < laws.elements.size(); ++e) {
    if (!laws.elements[e].law) continue;
    bool any = false;
    for (const ToolRuns* t : tools)
      for (const propagate::ToolRun& run : t->runs)
        for (const error_model::Term& term : run.model->terms)
          any =
              any || (term.sigma != 0 && has_law(term) &&
                      propagate::reference_element(term.code, term.function->name) == static_cast<ReferenceElement>(e));
    if (!any)
      c.warn("reference_law." + random::reference_elements()[e],
             "changes nothing: no error model here has a term of this element in the modes that have the law",
             "leave it out, or take a model with such a term (surveymc models shows them)");
  }
}

}  // namespace surveymc::scenario
