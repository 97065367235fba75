#pragma once
#include <Eigen/Core>

namespace surveymc::monitoring {

/// Readings of p sensors at n times: n x p, one time a row.
using Samples = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace surveymc::monitoring
