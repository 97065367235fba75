#pragma once
/// A reference well and offset wells as a config gives them, and pairs of them ready to be compared: what the studies
/// of two and more wells share (docs/keys.md has the keys).
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/config.h"
#include "disturbance/station_disturbance.h"
#include "propagate/well_errors.h"
#include "proximity/pair_scan.h"
#include "scenario/error_models.h"
#include "scenario/validity_tables.h"
#include "store/table.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::scenario {

/// A well and the tools that it was surveyed with.
struct SurveyedWell {
  std::string name;  ///< "reference" of the reference
  survey::Survey survey;
  survey::ReferenceField field;
  double latitude = 0;  ///< rad; NaN where no model needs it
  ToolRuns tools;
  /// Of a sidetrack: with a run of its own below the kick-off, even where it has the tool of the reference. `tools`
  /// takes it as one well, whose run goes on.
  ToolRuns tools_from_kickoff = {};
  std::vector<double> tvd;  ///< for the error models, m
  Eigen::Vector3d slot = Eigen::Vector3d::Zero();
  double hole_diameter = 0;                 ///< m
  std::optional<std::size_t> kickoff = {};  ///< of a sidetrack: the station down to which it is the reference
  config::ConfigPlace model_place = {};     ///< where its error model is named
  std::optional<disturbance::Disturbance> disturbance = {};  ///< its terms are in the models of `tools`
};

/// How shared errors of two wells are taken into account.
struct PairFormulation {
  enum class Kind { sharing, shared_hole, zeroed };
  std::string name;
  Kind kind = Kind::sharing;
  proximity::Sharing sharing = proximity::Sharing::none;
  std::vector<std::string> codes = {};

  /// Sidetracks alone have some formulations.
  bool is_for(const SurveyedWell& offset) const { return kind == Kind::sharing || offset.kickoff.has_value(); }
};

struct WellPairs {
  SurveyedWell reference;
  std::vector<SurveyedWell> offsets;
  std::vector<PairFormulation> formulations;
  proximity::SeparationRule rule;
  proximity::Interpolation interpolation = proximity::Interpolation::covariance;
};

/// `[survey]`, `[field]`, `[error_model]`, `[[leg]]` of the reference, `[[offset]]`, and of `[separation]`
/// `scale_factor, surface_margin_m, project_ahead_m, interpolation, formulations`; `[disturbance]`, whose draws in two
/// wells are independent: they are drilled at different times. Not with a sidetrack.
WellPairs read_well_pairs(config::ConfigReader& config);

/// Throws InputError where a well has more errors of a disturbance than can be drawn, or shared between stations.
void require_few_disturbed(config::ConfigReader& config, const WellPairs& wells);

/// `errors.multiplier` (1): of the sizes of all models. After everything that names their terms was read.
void scale_models(config::ConfigReader& config, WellPairs& wells);

/// Effect of the drawn errors on a well that is surveyed with `tools`: its own tools, or those of a sidetrack.
propagate::WellErrors drawn_errors(const SurveyedWell& well, const ToolRuns& tools, propagate::VerticalRule vertical);

/// Warnings of where the models of a well's tools do not hold. `non_finite`: terms of its covariance.
std::vector<compare::Warning> warnings_of(const SurveyedWell& well,
                                          const std::vector<propagate::NonFiniteTerm>& non_finite = {});

/// Table `paths`: every station of every well in one frame, north (true), east, down.
store::Table paths_table(const WellPairs& wells);

/// The reference well with what every pair needs of it; made by pair_reference().
class PairReference {
 public:
  const SurveyedWell& well() const { return well_; }
  const proximity::WellPath& path() const { return path_; }
  std::shared_ptr<const proximity::PositionErrors> errors() const { return errors_; }
  /// Effects of all sources, for sidetracks.
  const propagate::StationEffects& effects() const;
  const std::vector<propagate::NonFiniteTerm>& non_finite() const { return non_finite_; }

 private:
  friend PairReference pair_reference(const SurveyedWell&, proximity::Interpolation);
  PairReference(const SurveyedWell& well, proximity::WellPath path) : well_(well), path_(std::move(path)) {}

  const SurveyedWell& well_;
  proximity::WellPath path_;
  std::vector<propagate::NonFiniteTerm> non_finite_;
  std::shared_ptr<const proximity::PositionErrors> errors_;
  mutable std::unique_ptr<propagate::StationEffects> effects_;
};

/// `well` must outlive it.
PairReference pair_reference(const SurveyedWell& well, proximity::Interpolation interpolation);

/// A reference and an offset; made by well_pair().
struct WellPair {
  const SurveyedWell* offset = nullptr;
  std::unique_ptr<const proximity::WellPath> offset_path;
  proximity::PairGeometry geometry = {};
  std::vector<proximity::PairErrors> formulations;  ///< those that are for this offset, in the order of the scenario
  std::vector<propagate::NonFiniteTerm> non_finite;

  const proximity::PairErrors& formulation(const std::string& name) const;
};

/// The reference and the wells must outlive it.
WellPair well_pair(const WellPairs& wells, const PairReference& reference, const SurveyedWell& offset);

}  // namespace surveymc::scenario
