#pragma once
/// Weighted least squares on the readings themselves (thesis eqs 8-10, 19-21), with known attitude and field: per axis
/// dy = m - Bc = e_S Bc + bias + noise, linear, with prior e_S ~ N(0, gain^2), bias ~ N(0, bias^2).
///   x = P H'(H P H' + R)^-1 dy,   U = (H'R^-1 H + P^-1)^-1
/// R and P are diagonal, so the three axes are three problems of two unknowns. (The thesis' eq 9 puts the biases first
/// and its H the scale factors.) gain = 1 + e_S.
#include <memory>

#include "estimate/estimator.h"

namespace surveymc::estimate {

/// R is assumed.magnetometer^2 or, where the readings carry `assumed_sd`, the square of that of each reading and trial.
/// A prior sd of 0 stands for no prior. `truth`: the true field at every station. Writes claimed_variance, the diagonal
/// of U. Throws InputError unless assumed.magnetometer > 0 and there is one truth for each station.
std::unique_ptr<Estimator> make_wls(const InputErrors& assumed, const std::vector<survey::StationFields>& truth);

}  // namespace surveymc::estimate
