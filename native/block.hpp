// A few points at a time, one coordinate an array, so that loops over them become vector code.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace circumspect {

constexpr int kBlock = 256;
constexpr double kLargestCoordinate = 1e50;  // fourth powers of anything smaller stay finite

struct Block {
  alignas(64) double x[kBlock], y[kBlock], z[kBlock];
  alignas(64) int32_t i[kBlock], j[kBlock], k[kBlock];  // cell; all three -1 outside the grid
};

struct Cell {
  int32_t i, j, k;  // all three -1 outside the grid
};

struct Shape {
  int32_t i, j, k;
  std::size_t cells() const { return std::size_t(i) * std::size_t(j) * std::size_t(k); }
  // Where a cell within the grid is in the array of all.
  std::size_t number_of(const Cell& cell) const {
    const std::size_t row = std::size_t(cell.i) * std::size_t(j) + std::size_t(cell.j);
    return row * std::size_t(k) + std::size_t(cell.k);
  }
};

// Cells from the first boundary of what reaches from -half to half. In halves, so that the middle
// plane, where objects have theirs, is a whole number of cells, whatever the size.
inline double cells_from_side(double at, double per_half, double half_cells) {
  return (at * per_half + 1.0) * half_cells;
}

// Copies rows [0, count) of (n, 3) points; returns how many are NaN, infinite or too large.
int64_t load(const double* rows, int count, Block& block);
int64_t load(const float* rows, int count, Block& block);

// How many of (n, 3) points are NaN, infinite or too large.
int64_t unusable(const double* rows, std::size_t count);
int64_t unusable(const float* rows, std::size_t count);

}  // namespace circumspect
