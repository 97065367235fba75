#pragma once
/// Two wells drawn from their error models as a limit state: g = least distance of both paths, over all pairs of
/// depths, less the radii of both holes.
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "propagate/drawn_well.h"
#include "proximity/drawn_contact.h"
#include "proximity/drawn_pair.h"
#include "rare/limit_state.h"
#include "rare/mixing_normal.h"
#include "rare/proposal.h"

namespace surveymc::proximity {

/// One of the two wells.
struct DrawnWellPlace {
  const propagate::WellErrors* errors = nullptr;
  Eigen::Vector3d slot = Eigen::Vector3d::Zero();     ///< north, east, down, m
  Eigen::Vector3d slot_sd = Eigen::Vector3d::Zero();  ///< m: one draw a well
  std::size_t first = 0;                              ///< station from which on the well counts
  std::uint32_t number = 0;                           ///< of the well: 0 is the reference
  const random::ReferenceLaws* laws = nullptr;        ///< of the reference field; null: normal
};

class ContactState final : public rare::LimitState {
 public:
  /// Addresses of the normals in the stream: those of the study clearance, and the slots'.
  const std::vector<rare::NormalCall>& calls() const { return calls_; }
  int dimension() const override { return static_cast<int>(4 * calls_.size()); }
  /// g everywhere; NaN where a path is not finite, here and below.
  void evaluate(const survey::LaneArray& z, int groups, double* g) const override;
  /// g where it is 0 or less; elsewhere some positive number, which is enough to tell hits. `depths`, if not null:
  /// measured depths on reference and offset where the hits touch, two a trial, m.
  void evaluate_hits(const survey::LaneArray& z, int groups, double* g, double* depths) const;
  /// The contact of one trial of a batch, and its measured depths on both wells, m.
  Contact contact(const survey::LaneArray& z, int trial, double& reference_md, double& offset_md) const;

  /// J: the derivative of offset - reference by every normal, 3 x n, m. Draws that are not normal have V = 1.
  Eigen::Matrix3Xd derivative(const propagate::WellErrors& reference, const propagate::WellErrors& offset,
                              const propagate::WellPoint& reference_point,
                              const propagate::WellPoint& offset_point) const;

  /// Of errors that last.
  const std::vector<rare::MixingNormal>& mixing() const { return mixing_; }

  /// Which draw a normal is: the source's code and mode, in which well.
  struct NormalName {
    int well = 0;              ///< 0 reference, 1 offset, 2 both; -1: not used
    std::uint32_t source = 0;  ///< in WellErrors::sources of that well (both: of the reference); kSlot: the place
  };
  static constexpr std::uint32_t kSlot = 0xffffffffu;
  const std::vector<NormalName>& names() const { return names_; }

 private:
  friend ContactState contact_state(const DrawnWellPlace&, const DrawnWellPlace&, const SharedDraws&, double);
  struct Side {
    Eigen::Vector3d slot, slot_sd;
    std::vector<double> md;
    std::size_t first = 0;
    int slot_row = 0;
    propagate::DrawnWell well;
    std::vector<std::uint32_t> rows;       ///< of the well's calls
    std::vector<std::uint32_t> draw_rows;  ///< of its draws
    propagate::WellMixing mixing;
    std::vector<std::uint32_t> slot_rows;  ///< of the well's slots
  };
  ContactState(double radii, Side reference, Side offset)
      : radii_(radii), reference_(std::move(reference)), offset_(std::move(offset)) {}
  static Side make_side(const DrawnWellPlace& place, const std::vector<propagate::DrawPlace>& places);
  void name_normals(const Side& side, const propagate::WellErrors& errors, int well);
  void add_rows(Side& side, const std::vector<propagate::DrawPlace>& places);
  void add_mixing(Side& side, const propagate::WellErrors& errors);
  int row_of(random::Channel channel, std::uint32_t index);
  template <class EachTrial>
  void each(const survey::LaneArray& z, int groups, EachTrial each_trial) const;
  static double md_of(const Side& side, std::size_t leg, double share);
  static void set_path(const Side& side, const survey::LaneArray& drawn, const survey::LaneArray& z, int trial,
                       DrawnPath& path);

  double radii_;
  std::vector<rare::NormalCall> calls_;
  std::vector<NormalName> names_;
  std::vector<rare::MixingNormal> mixing_;
  Side reference_, offset_;
};

/// `radii`: R, of both holes together, m. The errors are not kept.
ContactState contact_state(const DrawnWellPlace& reference, const DrawnWellPlace& offset, const SharedDraws& shared,
                           double radii);

/// The same state with g only where it is 0 or less, for the trials of a run. Its marks are the depths of contact.
class HitState final : public rare::LimitState {
 public:
  explicit HitState(const ContactState& state) : state_(state) {}
  int dimension() const override { return state_.dimension(); }
  void evaluate(const survey::LaneArray& z, int groups, double* g) const override {
    state_.evaluate_hits(z, groups, g, nullptr);
  }
  int marks() const override { return 2; }
  void evaluate_marked(const survey::LaneArray& z, int groups, double* g, double* depths) const override {
    state_.evaluate_hits(z, groups, g, depths);
  }

 private:
  const ContactState& state_;
};

}  // namespace surveymc::proximity
