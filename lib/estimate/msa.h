#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "estimate/estimator.h"
#include "estimate/msa_valley.h"

namespace surveymc::estimate {

/// Multi-station analysis: minimises sum_k (Bh_k - Bh_ref)^2 + (Bv_k - Bv_ref)^2 over gains and biases.
/// See make_estimator for `truth` and `expected`.
std::unique_ptr<Estimator> make_msa(const NewtonOptions& options, const survey::ReferenceField& field,
                                    const std::vector<survey::StationFields>& truth,
                                    const std::vector<survey::Vec3<double>>& expected);

/// The same minimum, from the valley of each trial (msa_valley.h); null where there is none. For noise that is large
/// for the geometry. `truth` and `expected` must not be empty.
std::unique_ptr<Estimator> make_msa_in_valley(const NewtonOptions& options, const survey::ReferenceField& field,
                                              const std::vector<survey::StationFields>& truth,
                                              const std::vector<survey::Vec3<double>>& expected);

/// The same minimum from the start with which trials like `readings` cost least processor time: the minimum of the
/// expected readings, the valley of each trial, or unit gains. Costs are counted evaluations times constants
/// (msa_choice.cpp), so that the choice is the same on every machine. `truth` and `expected` must not be empty.
std::unique_ptr<Estimator> make_cheapest_msa(const NewtonOptions& options, const survey::ReferenceField& field,
                                             const std::vector<survey::StationFields>& truth,
                                             const std::vector<survey::Vec3<double>>& expected,
                                             const survey::ReadingBlock& readings);

/// From a start that has been made; from unit gains if there is none. Not both.
std::unique_ptr<Estimator> make_msa_from(const NewtonOptions& options, double total,
                                         std::optional<MsaExpansion> expansion, std::optional<MsaValley> valley);

/// One trial without noise: expected readings (nT, tool frame), down directions of `truth`, the nominal reference.
survey::ReadingBlock expected_readings(const std::vector<survey::StationFields>& truth,
                                       const std::vector<survey::Vec3<double>>& expected,
                                       const survey::ReferenceField& field);

/// The point from which trials start: solution and matrix of the expected readings, with the down directions of
/// `truth`. None where the expected readings have no sharp minimum.
std::optional<MsaExpansion> msa_expansion(const std::vector<survey::StationFields>& truth,
                                          const std::vector<survey::Vec3<double>>& expected,
                                          const survey::ReferenceField& field);

/// The valley of trials about the expected readings; arguments as msa_expansion. None where the expected readings have
/// no sharp minimum.
std::optional<MsaValley> msa_valley(const std::vector<survey::StationFields>& truth,
                                    const std::vector<survey::Vec3<double>>& expected,
                                    const survey::ReferenceField& field);

}  // namespace surveymc::estimate
