#pragma once
/// From fault-free readings to what a monitor remembers: scaling and memory vectors.
#include <vector>

#include "monitoring/samples.h"

namespace surveymc::monitoring {

/// z = (x - mean) / sd, per sensor; sd is that of the population (divided by n).
struct Scaling {
  Eigen::RowVectorXd mean, sd;

  Samples to_z(const Samples& readings) const;
  Samples from_z(const Samples& z) const;
};

/// Population standard deviation of every column.
Eigen::RowVectorXd population_sd(const Samples& x);

/// Of fault-free readings (n x p, n >= 2). InputError names the first sensor (by number from 1) that does not vary.
Scaling fit_scaling(const Samples& training);

/// Rows of `z` to remember, `count` of them, none twice. First the row of the largest and of the smallest value of each
/// sensor (the first of equals; rows already chosen are not chosen again), then the others ordered by Euclidean norm
/// (equals stay in order), of which the ranks floor(k R / missing), k = 0, 1, ... of R are taken. Hines et al. 2008,
/// min-max and vector ordering. InputError unless 2 p <= count <= n.
std::vector<Eigen::Index> select_memory(const Samples& z, Eigen::Index count);

/// The rows of x with these numbers.
Samples rows_of(const Samples& x, const std::vector<Eigen::Index>& rows);

}  // namespace surveymc::monitoring
