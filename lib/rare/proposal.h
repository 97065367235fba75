#pragma once
/// The proposal of importance sampling: a mixture of normal distributions in a few directions of the standard normals
/// z; the other directions keep their normals.
///
///   y = U' z (r coordinates),  q(y) = sum_k a_k N(y; m_k, L_k L_k'),  a draw: z + U (m_k + L_k y - y)
///   weight w = phi_r(y) / q(y), of the drawn y, by the whole mixture
/// Everything adaptive comes before (preparing.h): trials are independent, and their bits those of any split.
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "random/stream.h"
#include "rare/limit_state.h"
#include "rare/normals_lanes.h"

namespace surveymc::rare {

enum class ComponentKind { adapted, shifted, wide };
/// "adapted", "shifted", "wide".
const char* name_of(ComponentKind kind);

struct Component {
  ComponentKind kind = ComponentKind::shifted;
  double share = 1;       ///< a_k > 0; those of a proposal add up to 1
  Eigen::VectorXd mean;   ///< m_k, r
  Eigen::MatrixXd root;   ///< L_k, r x r, lower, with a positive diagonal
  int design_point = -1;  ///< the design point it was made from; -1: none
};

class Proposal {
 public:
  /// Plain trials: no component, all weights 1.
  Proposal() = default;
  /// `basis`: U, n x r, orthonormal columns.
  Proposal(Eigen::MatrixXd basis, std::vector<Component> components);

  bool is_plain() const { return components_.empty(); }
  const Eigen::MatrixXd& basis() const { return basis_; }
  const std::vector<Component>& components() const { return components_; }
  /// The component of a uniform number in (0, 1).
  std::size_t choose(double uniform) const;
  /// ln phi_r(y) / q(y).
  double log_weight(const double* y) const;
  /// ln of a_k N(y; m_k, C_k) / phi_r(y).
  double log_ratio(std::size_t component, const double* y) const;
  /// Hash of all numbers, never 0; 0 for a plain proposal.
  std::uint64_t hash() const;

 private:
  Eigen::MatrixXd basis_;
  std::vector<Component> components_;
  std::vector<double> log_scale_;  // ln a_k - ln det L_k
};

/// Trials drawn from a proposal.
struct DrawnTrials {
  survey::LaneArray z;                   ///< n rows
  std::vector<double> log_weight;        ///< of every trial
  std::vector<std::uint32_t> component;  ///< of every trial; 0 of plain ones
  Eigen::MatrixXd y;                     ///< r x trials
};

/// Addresses of normals and choices of a proposal's trials in the stream.
struct TrialAddresses {
  std::vector<NormalCall> calls;  ///< four rows each, in order; what is beyond n is not used
  random::Channel choice{};       ///< of the uniform number that chooses the component
};

/// Normals number 0 .. n - 1 of a channel.
TrialAddresses addresses_in(random::Channel normals, random::Channel choice, int n);

/// Trials first_trial .. first_trial + 8 groups - 1 of n normals; first_trial is a multiple of kGroup.
void draw_trials(const Proposal& proposal, const TrialAddresses& from, const random::Stream& stream,
                 std::uint64_t first_trial, int groups, int n, DrawnTrials& out);

}  // namespace surveymc::rare
