// Points into cells: indices, and occupancy by hits (equation 3 of the paper).
#pragma once

#include <algorithm>
#include <atomic>

#include "block.hpp"
#include "parallel.hpp"

namespace circumspect {

constexpr std::size_t kPointsPerThread = 8192;

// Threads may mark one cell at a time, always with the same value.
inline void mark(uint8_t* cell, uint8_t value) { __atomic_store_n(cell, value, __ATOMIC_RELAXED); }

// Calls visit(point, i, j, k) with the cell of each point, i < 0 outside; returns how many points
// were not usable.
template <typename Grid, typename T, typename Visit>
int64_t for_each_cell(const Grid& grid, const T* points_xyz, std::size_t count, std::size_t threads,
                      const Visit& visit) {
  std::atomic<int64_t> bad{0};
  parallel_for(count, threads, kPointsPerThread, [&](std::size_t begin, std::size_t end) {
    Block block;
    int64_t bad_here = 0;
    for (std::size_t at = begin; at < end; at += kBlock) {
      const int here = int(std::min<std::size_t>(kBlock, end - at));
      bad_here += load(points_xyz + 3 * at, here, block);
      grid.locate(block, here);
      for (int n = 0; n < here; ++n) {
        visit(at + std::size_t(n), block.i[n], block.j[n], block.k[n]);
      }
    }
    bad += bad_here;
  });
  return bad;
}

// Writes `value` into each cell that holds a point; returns how many points were not usable.
template <typename Grid, typename T>
int64_t mark_hits(const Grid& grid, const T* points_xyz, std::size_t count, uint8_t value,
                  uint8_t* states, std::size_t threads) {
  const std::size_t rows = std::size_t(grid.shape.j), layers = std::size_t(grid.shape.k);
  return for_each_cell(grid, points_xyz, count, threads,
                       [=](std::size_t, int32_t i, int32_t j, int32_t k) {
                         if (i < 0) return;
                         const std::size_t row = std::size_t(i) * rows + std::size_t(j);
                         mark(states + row * layers + std::size_t(k), value);
                       });
}

// Writes the (n, 3) cells of points, -1 outside; returns how many points were not usable.
template <typename Grid, typename T>
int64_t write_indices(const Grid& grid, const T* points_xyz, std::size_t count, int32_t* indices,
                      std::size_t threads) {
  return for_each_cell(grid, points_xyz, count, threads,
                       [=](std::size_t point, int32_t i, int32_t j, int32_t k) {
                         int32_t* row = indices + 3 * point;
                         row[0] = i, row[1] = j, row[2] = k;
                       });
}

}  // namespace circumspect
