// Beams into cells: which cells they passed.
#pragma once

#include <algorithm>
#include <atomic>

#include "beams.hpp"
#include "block.hpp"
#include "hits.hpp"
#include "parallel.hpp"

namespace circumspect {

constexpr std::size_t kBeamsPerThread = 2048;

// About the centre of the grid; x, y, z of the blocks are origins and ends.
void to_beams(const Block& origins, const Block& ends, double x, double y, double z,
              Beams& beams, int count);

// Writes `value` into each cell that a beam passed, its last cell included. One origin stands for
// all where `origin_count` is 1. Returns how many beams were not usable.
template <typename Tracer, typename Grid, typename T>
int64_t mark_passed(const Grid& grid, const T* origins_xyz, std::size_t origin_count,
                    const T* ends_xyz, std::size_t count, uint8_t value, uint8_t* states,
                    std::size_t threads) {
  std::atomic<int64_t> bad{0};
  parallel_for(count, threads, kBeamsPerThread, [&](std::size_t begin, std::size_t end) {
    Tracer tracer(grid);
    Block origins, ends;
    int64_t bad_here = 0;
    if (origin_count == 1) {
      T rows[3 * kBeams];
      for (int n = 0; n < 3 * kBeams; ++n) rows[n] = origins_xyz[n % 3];
      bad_here += load(rows, kBeams, origins) > 0;
    }
    for (std::size_t at = begin; at < end; at += kBeams) {
      const int here = int(std::min<std::size_t>(kBeams, end - at));
      if (origin_count > 1) bad_here += load(origins_xyz + 3 * at, here, origins);
      bad_here += load(ends_xyz + 3 * at, here, ends);
      if (bad_here > 0) continue;  // the caller will refuse all; only usable beams are traced
      to_beams(origins, ends, grid.x, grid.y, grid.z, tracer.beams(), here);
      tracer.trace(here);
    }
    bad += bad_here;
    uint8_t* state = states;
    for (int32_t i = 0; i < grid.shape.i; ++i) {
      for (int32_t j = 0; j < grid.shape.j; ++j) {
        for (int32_t k = 0; k < grid.shape.k; ++k, ++state) {
          if (tracer.passed(i, j, k)) mark(state, value);
        }
      }
    }
  });
  return bad;
}

}  // namespace circumspect
