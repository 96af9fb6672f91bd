// Solves symmetric equations whose matrix is sparse below a skyline.
#pragma once

#include <cstddef>
#include <vector>

namespace circumspect {

// The factorisation A = L D Lᵀ with a unit lower triangle L. Rows of L start where those of A do
// (Jennings, "A compact storage scheme for the solution of symmetric linear simultaneous
// equations", 1966). There is no pivoting: A is to be positive definite.
class Skyline {
 public:
  // Of the lower triangle of a row-major (size, size) matrix.
  Skyline(const double* A, std::size_t size);

  bool is_singular() const { return is_singular_; }
  // A⁻¹ b for `size` values.
  std::vector<double> solved(const double* b) const;
  // The last `count` rows and columns of A⁻¹.
  std::vector<double> inverse_end(std::size_t count) const;

 private:
  void substitute_back(double* x, std::size_t from) const;

  std::size_t size_;
  std::vector<double> L_;  // with D on its diagonal
  std::vector<std::size_t> first_;
  bool is_singular_ = false;
};

}  // namespace circumspect
