#include "skyline.hpp"

#include <algorithm>

namespace circumspect {

Skyline::Skyline(const double* A, std::size_t size)
    : size_(size), L_(A, A + size * size), first_(size) {
  for (std::size_t i = 0; i < size; ++i) {
    double* row = &L_[i * size];
    first_[i] = std::size_t(std::find_if(row, row + i, [](double a) { return a != 0.0; }) - row);
    for (std::size_t j = first_[i]; j < i; ++j) {  // L D of this row
      const double* other = &L_[j * size];
      for (std::size_t k = std::max(first_[i], first_[j]); k < j; ++k) row[j] -= row[k] * other[k];
    }
    for (std::size_t j = first_[i]; j < i; ++j) {
      const double l = row[j] / L_[j * size + j];
      row[i] -= row[j] * l;
      row[j] = l;
    }
    is_singular_ = is_singular_ || row[i] == 0.0;
  }
}

std::vector<double> Skyline::solved(const double* b) const {
  std::vector<double> x(b, b + size_);
  for (std::size_t i = 0; i < size_; ++i) {
    for (std::size_t j = first_[i]; j < i; ++j) x[i] -= L_[i * size_ + j] * x[j];
  }
  substitute_back(x.data(), 0);
  return x;
}

std::vector<double> Skyline::inverse_end(std::size_t count) const {
  // The last rows of L and D alone factorise the Schur complement, whose inverse this is.
  const std::size_t begin = size_ - count;
  std::vector<double> inverse(count * count), x(size_);
  for (std::size_t column = 0; column < count; ++column) {
    std::fill(x.begin(), x.end(), 0.0);
    x[begin + column] = 1.0;
    for (std::size_t i = begin + column + 1; i < size_; ++i) {
      for (std::size_t j = std::max(begin, first_[i]); j < i; ++j) x[i] -= L_[i * size_ + j] * x[j];
    }
    substitute_back(x.data(), begin);
    for (std::size_t row = column; row < count; ++row) {
      inverse[row * count + column] = inverse[column * count + row] = x[begin + row];
    }
  }
  return inverse;
}

// Solves D Lᵀ x = x for the unknowns from `from` on.
void Skyline::substitute_back(double* x, std::size_t from) const {
  for (std::size_t i = from; i < size_; ++i) x[i] /= L_[i * size_ + i];
  for (std::size_t i = size_; i-- > from;) {
    for (std::size_t j = std::max(from, first_[i]); j < i; ++j) x[j] -= L_[i * size_ + j] * x[i];
  }
}

}  // namespace circumspect
