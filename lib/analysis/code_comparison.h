#pragma once
/// Does a corrected tool code hold on a well? What is left after the correction (corrected_survey.h) against what the
/// code claims (propagate/code_claim.h), to first order.
#include <memory>
#include <optional>
#include <string>

#include "analysis/corrected_survey.h"
#include "propagate/code_claim.h"

namespace surveymc::analysis {

/// The terms that are compared: those that a correction of magnetometers can change, or all, of which the others are
/// the same on both sides.
enum class CodeScope { magnetic, total };
inline constexpr std::array<const char*, 2> kCodeScopes{"magnetic", "total"};

/// A base code, what is drawn of it, how it is corrected, and the code that is claimed for the result.
struct CodeCase {
  propagate::CodeDraws draws;
  double noise = 0;  ///< nT
  Correction correction;
  std::shared_ptr<const propagate::ClaimedCode> claimed;
  StationCorrelation correlation = {};  ///< of what is drawn at the stations
  bool turned = false;  ///< the tool of the whole run by any angle, as likely: what codes are the mean over
};

/// A survey before and after its correction, beside the claim. The last four belong to the last station.
struct CodeComparison {
  MeasuredStations stations;
  propagate::ClaimedErrors magnetic, carried;  ///< `carried` zero unless it was asked for
  CorrectedErrors before, after;
};
CodeComparison compare_code(const survey::Survey& survey, const survey::ReferenceField& field, const CodeCase& which,
                            bool with_carried);

/// Quantities at the last station; `azimuth` is one at every station. `worst`: the direction of the horizontal plane
/// in which the ratio is largest.
enum class CodeQuantity { lateral, high_side, north, east, worst, azimuth };
inline constexpr std::array<const char*, 6> kCodeQuantities{"lateral", "high_side", "north",
                                                            "east",    "worst",     "azimuth"};

/// Standard deviations: m; of azimuth, of sinI dA in rad. NaN where a correction is undetermined.
struct CodeSds {
  double claimed = 0, before = 0, after = 0;
  double ratio_before() const { return before / claimed; }
  double ratio() const { return after / claimed; }
};
/// `station`: of azimuth, entry of MeasuredStations.
CodeSds code_sds(const CodeComparison& comparison, const survey::Survey& survey, CodeQuantity quantity, CodeScope scope,
                 std::size_t station = 0);

/// The direction (N, E, V) in which a quantity of the last station is measured; of `worst` that of the magnetic scope,
/// of the corrected survey, or of the uncorrected one where that is undetermined.
Eigen::RowVector3d code_direction(const CodeComparison& comparison, const survey::Survey& survey,
                                  CodeQuantity quantity);

/// "holds" or "broken", as a ratio is at most 1 + margin or not; "undetermined" of NaN.
std::string code_verdict(double ratio, double margin);
/// The same of an interval: "undecided" if 1 + margin lies in it.
std::string code_verdict(double low, double high, double margin);
/// What a correction did: "free" (uncorrected readings would hold, too), "kept" (it makes the claim true), "broken",
/// "harmful" (uncorrected readings hold, corrected ones do not), "undetermined"; "undecided" if a verdict is.
std::string code_class(const std::string& before, const std::string& after);
inline constexpr std::array<const char*, 5> kCodeClasses{"free", "kept", "broken", "harmful", "undetermined"};

/// What would have to be: factors by which inputs may be multiplied until the ratio of `quantity` (of the last station,
/// scope magnetic) is 1 + margin: a + b f^2 = ((1 + margin) claimed)^2. NaN: never, infinite: whatever it is.
struct CodeRequirement {
  double reference = 0;     ///< of total field and dip, once a run
  double interference = 0;  ///< of the drill string
};
CodeRequirement code_requirement(const CodeComparison& comparison, const survey::Survey& survey, CodeQuantity quantity,
                                 double margin);

/// Codes with axial correction hold to first order where kappa is below this, in a level hole.
inline constexpr double kLargestKappa = 0.12;
/// sd of the error of the horizontal field that the correction matches, nT: reference, biases and scales of the cross
/// axes.
///   s_h^2 = (sB^2 + sBk^2) cos^2 dip + Bv^2 (sd^2 + sdk^2) + bias^2 + (scale Bh)^2
double horizontal_field_sd(const propagate::CodeDraws& draws, const survey::ReferenceField& field);
/// kappa = s_h / (Bh sin^2 x), x: angle between the hole and magnetic east or west. Curvature over slope of a level
/// hole; out of the level the curvature is smaller, and kappa an upper bound.
double axial_kappa(const propagate::CodeDraws& draws, const survey::ReferenceField& field, double inclination,
                   double azimuth);
/// Angle about magnetic east and west in which kappa is above kLargestKappa: asin sqrt(s_h / (kLargestKappa Bh)), rad;
/// pi / 2 where it is so everywhere.
double axial_half_angle(const propagate::CodeDraws& draws, const survey::ReferenceField& field);

/// Shares of the variance by input (CodeInput) of `quantity` at the last station. NaN where undetermined.
std::array<double, kCodeInputs> code_budget(const CorrectedErrors& errors, const CodeComparison& comparison,
                                            const survey::Survey& survey, CodeQuantity quantity);

}  // namespace surveymc::analysis
