// Points into cells: indices, and occupancy by hits (equation 3 of the paper).
#pragma once

#include <algorithm>
#include <atomic>

#include "block.hpp"
#include "parallel.hpp"

namespace circumspect {

constexpr std::size_t kPointsPerThread = 8192;

// Threads may mark one cell at a time, always with the same value.
inline void mark(uint8_t* cell, uint8_t value) {
  __atomic_store_n(cell, value, __ATOMIC_RELAXED);
}

// Writes `value` into each cell that holds a point; returns how many points were not usable.
template <typename Grid, typename T>
int64_t mark_hits(const Grid& grid, const T* points_xyz, std::size_t count, uint8_t value,
                  uint8_t* states, std::size_t threads) {
  std::atomic<int64_t> bad{0};
  parallel_for(count, threads, kPointsPerThread, [&](std::size_t begin, std::size_t end) {
    Block block;
    int64_t bad_here = 0;
    for (std::size_t at = begin; at < end; at += kBlock) {
      const int here = int(std::min<std::size_t>(kBlock, end - at));
      bad_here += load(points_xyz + 3 * at, here, block);
      grid.locate(block, here);
      for (int n = 0; n < here; ++n) {
        if (block.i[n] < 0) continue;
        const std::size_t i = std::size_t(block.i[n]), j = std::size_t(block.j[n]);
        const std::size_t row = i * std::size_t(grid.shape.j) + j;
        mark(states + row * std::size_t(grid.shape.k) + std::size_t(block.k[n]), value);
      }
    }
    bad += bad_here;
  });
  return bad;
}

// Writes the (n, 3) cells of points, -1 outside; returns how many points were not usable.
template <typename Grid, typename T>
int64_t write_indices(const Grid& grid, const T* points_xyz, std::size_t count, int32_t* indices,
                      std::size_t threads) {
  std::atomic<int64_t> bad{0};
  parallel_for(count, threads, kPointsPerThread, [&](std::size_t begin, std::size_t end) {
    Block block;
    int64_t bad_here = 0;
    for (std::size_t at = begin; at < end; at += kBlock) {
      const int here = int(std::min<std::size_t>(kBlock, end - at));
      bad_here += load(points_xyz + 3 * at, here, block);
      grid.locate(block, here);
      for (int n = 0; n < here; ++n) {
        int32_t* row = indices + 3 * (at + std::size_t(n));
        row[0] = block.i[n], row[1] = block.j[n], row[2] = block.k[n];
      }
    }
    bad += bad_here;
  });
  return bad;
}

}  // namespace circumspect
