#pragma once
#include <memory>
#include <optional>

#include "estimate/estimator.h"
#include "estimate/msa_chord.h"

namespace surveymc::estimate {

/// Multi-station analysis: minimises sum_k (Bh_k - Bh_ref)^2 + (Bv_k - Bv_ref)^2 over gains and biases.
/// See make_estimator for `truth` and `expected`.
std::unique_ptr<Estimator> make_msa(const NewtonOptions& options, const survey::ReferenceField& field,
                                    const std::vector<survey::StationFields>& truth,
                                    const std::vector<survey::Vec3<double>>& expected);

/// Where the trials start: solution and matrix of the expected readings, with the down directions of `truth`. None
/// where these have no sharp minimum.
std::optional<MsaExpansion> msa_expansion(const std::vector<survey::StationFields>& truth,
                                          const std::vector<survey::Vec3<double>>& expected,
                                          const survey::ReferenceField& field);

}  // namespace surveymc::estimate
