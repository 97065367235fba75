#pragma once
/// How often errors are larger than so many predicted standard deviations: trials against the prediction from the laws
/// of what is drawn (stats/heavy_tail.h), and against a normal distribution of the same covariance.
#include <string>
#include <vector>

#include "compare/annotations.h"
#include "compare/comparison.h"
#include "compare/row.h"
#include "montecarlo/blocks.h"
#include "propagate/mixed_errors.h"
#include "random/reference_laws.h"
#include "stats/heavy_tail.h"
#include "stats/tally.h"

namespace surveymc::compare {

/// `[tails]`.
struct TailRule {
  bool wanted = false;  ///< the tables are made
  std::vector<double> k{2, 3, 3.5};
  /// A probability within 1 -+ margin counts as equal; at 3.5 sd one of 20 % is a standard deviation that is 1.5 %
  /// wrong.
  double margin = 0.2;
  /// Else the laws of what is drawn are not known: rows of formulation "mixture" have trials, but no prediction.
  bool predicted = true;
};
/// `tails.k, tails.margin`. Wanted where one of them is given, or `laws` has a law.
TailRule read_tail_rule(config::ConfigReader& config, const random::ReferenceLaws& laws);

/// An error of a study along a direction.
struct TailQuantity {
  std::string name;                     ///< "lateral"
  double sd = 0;                        ///< the predicted one, of which there are k; 0: no error there
  std::vector<stats::HeavyPart> parts;  ///< of its variance; none: normal
  std::string place = {};               ///< of several wells: which; begins the formulation
};

/// Directions in which errors of a position are looked at; axes: of the ellipsoid, largest first.
inline const std::vector<std::string> kWellDirections{"north",      "east",   "vertical", "high_side", "lateral",
                                                      "along_hole", "axis_1", "axis_2",   "axis_3"};
struct WellTails {
  Eigen::Matrix<double, 3, 9> directions;  ///< columns: of kWellDirections
  std::vector<TailQuantity> quantities;
};
/// From the first-order effects of every draw; hla = `hla` nev.
WellTails well_tails(const propagate::WellMixing& mixing, const Eigen::Matrix3Xd& effects, const Eigen::Matrix3d& hla);

/// The rows of table `tails`: "lateral_beyond_3.5" of formulations "mixture" and "normal" for every name.
std::vector<Row> tail_rows(const std::vector<std::string>& names, const TailRule& rule, const std::string& place = {});

/// Adds 1 to counts[i] for every k[i] < |error| / sd.
void count_beyond(double error, double sd, const TailRule& rule, std::uint64_t* counts);

/// Table `tails`, from k.size() counts of each quantity in `runs` trials; sds are in metres.
store::Table tails_table(const std::vector<TailQuantity>& quantities, const TailRule& rule, const std::uint64_t* counts,
                         std::uint64_t runs, const VerdictRule& verdict, const Annotations& annotations,
                         std::uint64_t trials, std::uint64_t failed);

/// An error of an element that has a law: the address of its normal, and its V.
struct LawDraw {
  random::ReferenceElement element{};
  random::MixingSlot slot = {};
  random::Channel channel{};
  std::uint32_t index = 0;
};

/// Draws of one error of each element that has a law, in units of its sd: how the law came out.
class DrawnLaws {
 public:
  /// Draws them for a block of trials, of antithetic pairs one, and adds their moments and counts to the end of a
  /// tally. Without draws nothing.
  static void add(const random::Stream& stream, const std::vector<LawDraw>& draws, montecarlo::TrialBlock block,
                  bool antithetic, stats::Tally& tally);
  /// The same of draws at hand, `draws[e]` of element e.
  static void add(const std::vector<std::vector<double>>& draws, stats::Tally& tally);
  /// Numbers of counts that add() appends for so many elements.
  static std::size_t counts(std::size_t elements) { return elements * bins().bins; }
  static stats::HistogramBins bins() { return {4096, 1e-3}; }
};

/// Table `laws`: of each element with a law sd, 68.3 % and 95.4 % intervals and kurtosis, by the law and as drawn.
/// `drawn`: those that add() had; an element with a law that nothing draws is not among them. `moments` and `counts`:
/// where add() has put them; null without trials.
store::Table laws_table(const random::ReferenceLaws& laws, const std::vector<LawDraw>& drawn,
                        const stats::Moments* moments, const std::uint64_t* counts, double confidence);

}  // namespace surveymc::compare
