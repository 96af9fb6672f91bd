#include "smoother_window.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "se3.hpp"

namespace circumspect {
namespace {

constexpr double kQuadratic = std::numeric_limits<double>::infinity();  // kernel: none

// Where the columns of a Jacobian are among the variables.
template <std::size_t V>
using Columns = std::array<std::size_t, V>;

// Those of poses from the k-th on, then, if V is not a multiple of 6, those of the scale.
template <std::size_t V>
Columns<V> columns(std::size_t k, const NormalEquations& equations) {
  Columns<V> result;
  for (std::size_t i = 0; i < V; ++i) {
    result[i] = i < V - V % 6 ? 6 * k + i : equations.size - V + i;
  }
  return result;
}

template <std::size_t E>
bool is_zero(const double* information) {
  return std::all_of(information, information + E * E, [](double value) { return value == 0.0; });
}

// Adds a factor by its error, Jacobian and information, weighted by Cauchy's kernel.
template <std::size_t E, std::size_t V>
void add(NormalEquations& to, const Vector<E>& error, const Matrix<E, V>& J,
         const Matrix<E, E>& information, const Columns<V>& at, double kernel) {
  const double weight = 1.0 / (1.0 + dot(error, information * error) / (kernel * kernel));
  Matrix<V, E> J_omega = transposed(J) * information;
  for (auto& row : J_omega) {
    for (double& value : row) value *= weight;
  }
  const Matrix<V, V> H = J_omega * J;
  const Vector<V> gradient = J_omega * error;
  for (std::size_t i = 0; i < V; ++i) {
    to.gradient[at[i]] += gradient[i];
    for (std::size_t j = 0; j < V; ++j) to.hessian[at[i] * to.size + at[j]] += H[i][j];
  }
}

void add_prior(NormalEquations& to, const SmootherWindow& window) {
  const Transform prior = Transform::from_rows(window.prior_pose);
  const Vector<6> change = log(prior.inverse() * Transform::from_rows(window.T_map_camera));
  Vector<8> error;
  std::copy(change.begin(), change.end(), error.begin());
  Matrix<8, 8> J{};
  const Matrix<6, 6> by_pose = right_jacobian_inverse(change);
  for (std::size_t i = 0; i < 6; ++i) std::copy(by_pose[i].begin(), by_pose[i].end(), J[i].begin());
  for (std::size_t i = 0; i < 2; ++i) {
    error[6 + i] = window.scale[i] - window.prior_scale[i];
    J[6 + i][6 + i] = 1.0;
  }
  add(to, error, J, matrix_at<8, 8>(window.prior_information), columns<8>(0, to), kQuadratic);
}

void add_measured(NormalEquations& to, const SmootherWindow& window, std::size_t k, double kernel) {
  const double* information = window.measured_information + 36 * k;
  if (is_zero<6>(information)) return;
  const Transform measured = Transform::from_rows(window.measured + 16 * k);
  const Vector<6> error =
      log(measured.inverse() * Transform::from_rows(window.T_map_camera + 16 * k));
  add(to, error, right_jacobian_inverse(error), matrix_at<6, 6>(information), columns<6>(k, to),
      kernel);
}

// Roll, pitch and height of the base; see se3.level_error.
void add_level(NormalEquations& to, const SmootherWindow& window, std::size_t k) {
  const double* information = window.level_information + 9 * k;
  if (is_zero<3>(information)) return;
  const Transform mount = Transform::from_rows(window.mounts + 16 * k);
  const Transform base = Transform::from_rows(window.T_map_camera + 16 * k) * mount.inverse();
  const Vector<3>& up = base.R[2];
  Matrix<3, 6> by_base{};
  by_base[0][0] = by_base[1][1] = up[2];
  std::copy(up.begin(), up.end(), by_base[2].begin() + 3);
  add(to, Vector<3>{up[1], -up[0], base.t[2]}, by_base * adjoint(mount),
      matrix_at<3, 3>(information), columns<6>(k, to), kQuadratic);
}

void add_motion(NormalEquations& to, const SmootherWindow& window, std::size_t k, double kernel) {
  const Matrix<6, 2> by_scale = matrix_at<6, 2>(window.by_scale + 12 * k);
  const Transform expected = Transform::from_rows(window.motions + 16 * k) *
                             exp(by_scale * Vector<2>{window.scale[0] - 1, window.scale[1] - 1});
  const Transform before = Transform::from_rows(window.T_map_camera + 16 * k);
  const Transform between =
      before.inverse() * Transform::from_rows(window.T_map_camera + 16 * (k + 1));
  const Vector<6> error = log(expected.inverse() * between);
  Vector<6> opposite;
  std::transform(error.begin(), error.end(), opposite.begin(), [](double e) { return -e; });
  const Matrix<6, 6> by_now = right_jacobian_inverse(error);
  const Matrix<6, 6> by_before = by_now * adjoint(between.inverse());
  const Matrix<6, 2> by_scales = right_jacobian_inverse(opposite) * by_scale;
  Matrix<6, 14> J;
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) {
      J[i][j] = -by_before[i][j];
      J[i][6 + j] = by_now[i][j];
    }
    for (std::size_t j = 0; j < 2; ++j) J[i][12 + j] = -by_scales[i][j];
  }
  add(to, error, J, matrix_at<6, 6>(window.motion_information + 36 * k), columns<14>(k, to),
      kernel);
}

}  // namespace

NormalEquations linearised(const SmootherWindow& window, double kernel, std::size_t count) {
  NormalEquations equations(std::min(count + 1, window.poses));
  add_prior(equations, window);
  for (std::size_t k = 0; k < count; ++k) {
    add_measured(equations, window, k, kernel);
    add_level(equations, window, k);
    if (k + 1 < window.poses) add_motion(equations, window, k, kernel);
  }
  return equations;
}

}  // namespace circumspect
