#include "se3.hpp"

#include <cmath>

namespace circumspect {
namespace {

constexpr double kMinClosedForm = 1e-3;  // [rad]; smaller rotations use series

Matrix<3, 3> skew(double x, double y, double z) {
  return {{{0.0, -z, y}, {z, 0.0, -x}, {-y, x, 0.0}}};
}

// Unit quaternion (x, y, z, w) with w >= 0 of a rotation. The largest component is computed first
// (Shepperd, "Quaternion from rotation matrix", 1978), so that half turns lose no accuracy.
Vector<4> quaternion(const Matrix<3, 3>& R) {
  const double trace = R[0][0] + R[1][1] + R[2][2];
  std::size_t i = 0;
  for (std::size_t n = 1; n < 3; ++n) {
    if (R[n][n] > R[i][i]) i = n;
  }
  Vector<4> q;
  if (trace >= R[i][i]) {
    q = {R[2][1] - R[1][2], R[0][2] - R[2][0], R[1][0] - R[0][1], 1.0 + trace};
  } else {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    q[i] = 1.0 - trace + 2.0 * R[i][i];
    q[j] = R[j][i] + R[i][j];
    q[k] = R[k][i] + R[i][k];
    q[3] = R[k][j] - R[j][k];
  }
  const double norm = std::copysign(std::sqrt(dot(q, q)), q[3]);
  for (double& value : q) value /= norm;
  return q;
}

Vector<3> rotation_vector(const Matrix<3, 3>& R) {
  const Vector<4> q = quaternion(R);
  const double sine = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
  const double angle = 2.0 * std::atan2(sine, q[3]);
  const double factor = angle < kMinClosedForm ? 2.0 + angle * angle / 12.0 : angle / sine;
  return {factor * q[0], factor * q[1], factor * q[2]};
}

}  // namespace

Transform Transform::from_rows(const double* T) {
  return {matrix_at<3, 3>(T, 4), {T[3], T[7], T[11]}};
}

void Transform::to_rows(double* T) const {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) T[4 * i + j] = R[i][j];
    T[4 * i + 3] = t[i];
  }
  T[12] = T[13] = T[14] = 0.0;
  T[15] = 1.0;
}

Transform Transform::inverse() const {
  const Matrix<3, 3> Rt = transposed(R);
  const Vector<3> back = Rt * t;
  return {Rt, {-back[0], -back[1], -back[2]}};
}

Transform operator*(const Transform& a, const Transform& b) {
  const Vector<3> turned = a.R * b.t;
  return {a.R * b.R, {turned[0] + a.t[0], turned[1] + a.t[1], turned[2] + a.t[2]}};
}

Transform exp(const Vector<6>& xi) {
  const double square = xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2];
  const double angle = std::sqrt(square);
  double a = 1.0 - square / 6.0, b = 0.5 - square / 24.0, c = 1.0 / 6.0 - square / 120.0;
  if (angle >= kMinClosedForm) {
    const double half = std::sin(0.5 * angle);
    a = std::sin(angle) / angle;
    b = 2.0 * half * half / square;
    c = (1.0 - a) / square;
  }
  const Matrix<3, 3> K = skew(xi[0], xi[1], xi[2]), K2 = K * K;
  const Vector<3> rho{xi[3], xi[4], xi[5]}, once = K * rho, twice = K2 * rho;
  Transform T;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      T.R[i][j] = (i == j ? 1.0 : 0.0) + a * K[i][j] + b * K2[i][j];
    }
    T.t[i] = rho[i] + b * once[i] + c * twice[i];
  }
  return T;
}

Vector<6> log(const Transform& T) {
  const Vector<3> phi = rotation_vector(T.R);
  const double square = dot(phi, phi), half = 0.5 * std::sqrt(square);
  double k = 1.0 / 12.0 + square / 720.0;
  if (2.0 * half >= kMinClosedForm) k = (1.0 - half / std::tan(half)) / square;
  const Matrix<3, 3> K = skew(phi[0], phi[1], phi[2]);
  const Vector<3> once = K * T.t, twice = K * once;
  Vector<6> xi{phi[0], phi[1], phi[2]};
  for (std::size_t i = 0; i < 3; ++i) xi[3 + i] = T.t[i] - 0.5 * once[i] + k * twice[i];
  return xi;
}

Matrix<6, 6> adjoint(const Transform& T) {
  const Matrix<3, 3> lower = skew(T.t[0], T.t[1], T.t[2]) * T.R;
  Matrix<6, 6> Ad{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      Ad[i][j] = Ad[3 + i][3 + j] = T.R[i][j];
      Ad[3 + i][j] = lower[i][j];
    }
  }
  return Ad;
}

Matrix<6, 6> right_jacobian_inverse(const Vector<6>& xi) {
  const Matrix<3, 3> turn = skew(xi[0], xi[1], xi[2]), shift = skew(xi[3], xi[4], xi[5]);
  Matrix<6, 6> ad{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      ad[i][j] = ad[3 + i][3 + j] = turn[i][j];
      ad[3 + i][j] = shift[i][j];
    }
  }
  const Matrix<6, 6> square = ad * ad, fourth = square * square;
  Matrix<6, 6> J;
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) {
      J[i][j] = (i == j ? 1.0 : 0.0) + ad[i][j] / 2.0 + square[i][j] / 12.0 - fourth[i][j] / 720.0;
    }
  }
  return J;
}

}  // namespace circumspect
