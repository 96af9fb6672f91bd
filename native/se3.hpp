// SE(3) algebra. Conventions are those of geometry/se3.py: a tangent vector ξ = (φ, ρ) holds
// rotation [rad] before translation [m].
#pragma once

#include "small_matrix.hpp"

namespace circumspect {

struct Transform {
  Matrix<3, 3> R;
  Vector<3> t;

  // From the first three rows of a row-major 4 x 4 matrix.
  static Transform from_rows(const double* T);
  // Writes all rows of the 4 x 4 matrix.
  void to_rows(double* T) const;
  Transform inverse() const;
};

Transform operator*(const Transform& a, const Transform& b);
Transform exp(const Vector<6>& xi);
Vector<6> log(const Transform& T);
// T exp(ξ) = exp(Ad ξ) T.
Matrix<6, 6> adjoint(const Transform& T);
// J with log(exp(ξ) exp(δ)) = ξ + J δ for small δ; truncated as in se3.py.
Matrix<6, 6> right_jacobian_inverse(const Vector<6>& xi);

}  // namespace circumspect
