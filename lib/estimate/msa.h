#pragma once
#include <memory>

#include "estimate/estimator.h"
#include "estimate/msa_kernel.h"

namespace surveymc {

/// Multi-station analysis: minimises sum_k (Bh_k - Bh_ref)^2 + (Bv_k - Bv_ref)^2 over gains and biases.
std::unique_ptr<Estimator> make_msa(const MsaOptions& options, const ReferenceField& field);

}  // namespace surveymc
