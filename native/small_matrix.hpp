// Dense matrices of a fixed size.
#pragma once

#include <array>
#include <cstddef>

namespace circumspect {

template <std::size_t R, std::size_t C>
using Matrix = std::array<std::array<double, C>, R>;
template <std::size_t R>
using Vector = std::array<double, R>;

// The R x C block of row-major values whose rows are `stride` apart.
template <std::size_t R, std::size_t C>
Matrix<R, C> matrix_at(const double* values, std::size_t stride = C) {
  Matrix<R, C> result;
  for (std::size_t i = 0; i < R; ++i) {
    for (std::size_t j = 0; j < C; ++j) result[i][j] = values[i * stride + j];
  }
  return result;
}

template <std::size_t R, std::size_t C>
Matrix<C, R> transposed(const Matrix<R, C>& a) {
  Matrix<C, R> result;
  for (std::size_t i = 0; i < R; ++i) {
    for (std::size_t j = 0; j < C; ++j) result[j][i] = a[i][j];
  }
  return result;
}

template <std::size_t R, std::size_t K, std::size_t C>
Matrix<R, C> operator*(const Matrix<R, K>& a, const Matrix<K, C>& b) {
  Matrix<R, C> result{};
  for (std::size_t i = 0; i < R; ++i) {
    for (std::size_t k = 0; k < K; ++k) {
      for (std::size_t j = 0; j < C; ++j) result[i][j] += a[i][k] * b[k][j];
    }
  }
  return result;
}

template <std::size_t R, std::size_t C>
Vector<R> operator*(const Matrix<R, C>& a, const Vector<C>& x) {
  Vector<R> result{};
  for (std::size_t i = 0; i < R; ++i) {
    for (std::size_t j = 0; j < C; ++j) result[i] += a[i][j] * x[j];
  }
  return result;
}

template <std::size_t R>
double dot(const Vector<R>& a, const Vector<R>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < R; ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace circumspect
