#pragma once
/// Products of matrices whose size is known only when the program runs. Only this module's source file
/// instantiates Eigen's blocked product, because each kind of it takes a second to compile.
#include <Eigen/Core>

namespace surveymc::stats {

/// A B.
Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
/// c = a b, without memory from the heap. c is neither a nor b, and has their size.
void set_product(const Eigen::Ref<const Eigen::MatrixXd>& a, const Eigen::Ref<const Eigen::MatrixXd>& b,
                 Eigen::Ref<Eigen::MatrixXd> c);
/// A B where the compiler knows the columns of A, 3 or 6. Small products are then added by halves, as Eigen does.
template <int N>
Eigen::MatrixXd product_over(const Eigen::Matrix<double, Eigen::Dynamic, N>& a,
                             const Eigen::Matrix<double, N, Eigen::Dynamic>& b);
/// A' B.
Eigen::MatrixXd transpose_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
/// A B'.
Eigen::MatrixXd product_transpose(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
/// A A'.
Eigen::Matrix3d square(const Eigen::Matrix3Xd& a);

/// A x.
Eigen::VectorXd times(const Eigen::MatrixXd& a, const Eigen::VectorXd& x);
/// A' x.
Eigen::VectorXd transpose_times(const Eigen::MatrixXd& a, const Eigen::VectorXd& x);
/// y becomes y + A x.
void add_times(const Eigen::MatrixXd& a, const Eigen::VectorXd& x, Eigen::VectorXd& y);

/// S A S with S = diag(s).
Eigen::MatrixXd scaled(const Eigen::MatrixXd& a, const Eigen::VectorXd& s);

}  // namespace surveymc::stats
