#pragma once
/// Two wells of the study, ready to be compared in every formulation.
#include <memory>
#include <string>
#include <vector>

#include "clearance/scenario.h"
#include "proximity/pair_scan.h"

namespace surveymc::studies::clearance {

/// The reference, and what of it every pair needs.
class Reference {
 public:
  Reference(const Well& well, proximity::Interpolation interpolation);

  const Well& well() const { return well_; }
  const proximity::WellPath& path() const { return path_; }
  std::shared_ptr<const proximity::PositionErrors> errors() const { return errors_; }
  /// Effects of all sources, for sidetracks.
  const propagate::StationEffects& effects() const;
  const std::vector<propagate::NonFiniteTerm>& non_finite() const { return non_finite_; }

 private:
  const Well& well_;
  proximity::WellPath path_;
  std::vector<propagate::NonFiniteTerm> non_finite_;
  std::shared_ptr<const proximity::PositionErrors> errors_;
  mutable std::unique_ptr<propagate::StationEffects> effects_;
};

/// A reference and an offset. The wells must outlive it.
struct Pair {
  const Well* offset;
  proximity::WellPath offset_path;
  proximity::PairGeometry geometry;
  std::vector<proximity::PairErrors> formulations;  ///< those that are for this offset, in the order of the scenario
  std::vector<propagate::NonFiniteTerm> non_finite;

  Pair(const Scenario& scenario, const Reference& reference, const Well& offset);
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;

  const proximity::PairErrors& formulation(const std::string& name) const;
};

}  // namespace surveymc::studies::clearance
