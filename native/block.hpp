// A few points at a time, one coordinate an array, so that loops over them become vector code.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace circumspect {

constexpr int kBlock = 256;
constexpr double kLargestCoordinate = 1e100;  // squares of anything smaller stay finite

struct Block {
  alignas(64) double x[kBlock], y[kBlock], z[kBlock];
  alignas(64) int32_t i[kBlock], j[kBlock], k[kBlock];  // cell; all three -1 outside the grid
};

struct Shape {
  int32_t i, j, k;
  std::size_t cells() const { return std::size_t(i) * std::size_t(j) * std::size_t(k); }
};

// Copies rows [0, count) of (n, 3) points; returns how many are NaN, infinite or too large.
template <typename T>
int64_t load(const T* rows, int count, Block& block) {
  for (int n = 0; n < count; ++n) {
    block.x[n] = double(rows[3 * n]);
    block.y[n] = double(rows[3 * n + 1]);
    block.z[n] = double(rows[3 * n + 2]);
  }
  int64_t bad = 0;
  for (int n = 0; n < count; ++n) {
    bad += !((std::fabs(block.x[n]) <= kLargestCoordinate) &
             (std::fabs(block.y[n]) <= kLargestCoordinate) &
             (std::fabs(block.z[n]) <= kLargestCoordinate));
  }
  return bad;
}

}  // namespace circumspect
