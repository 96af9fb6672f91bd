// Beams into the cells of several cylinders: which cells of each they passed.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "cylinder.hpp"
#include "cylinder_beams.hpp"
#include "parallel.hpp"
#include "trace.hpp"

namespace circumspect {

// Like `mark_passed` for every grid; the states of one grid follow those of another. Grids and
// blocks of beams are split over threads, grids first, so that few threads share a grid. A thread
// converts a block of beams once for all of its grids. Nothing is written where beams are unusable.
template <typename T>
int64_t mark_coaxial_passed(const std::vector<const Cylinder*>& grids, const T* origins_xyz,
                            std::size_t origin_count, const T* ends_xyz, std::size_t count,
                            uint8_t value, uint8_t* states, std::size_t threads) {
  const int64_t bad = unusable(origins_xyz, origin_count) + unusable(ends_xyz, count);
  if (bad > 0 || count == 0) return bad;
  const std::size_t blocks = (count + kBeams - 1) / kBeams;
  const auto work = [&](std::size_t begin, std::size_t end) {
    const std::size_t first = begin / blocks, last = (end - 1) / blocks;
    std::vector<std::unique_ptr<CylinderTracer>> tracers;
    for (std::size_t g = first; g <= last; ++g) {
      tracers.push_back(std::make_unique<CylinderTracer>(*grids[g]));
    }
    BeamRows<T> rows(origins_xyz, origin_count, ends_xyz);
    for (std::size_t block = 0; block < blocks; ++block) {
      const auto is_mine = [&](std::size_t g) {
        return begin <= g * blocks + block && g * blocks + block < end;
      };
      // A part in the middle of one grid does not need all beams.
      if (first == last && !is_mine(first)) continue;
      const std::size_t at = block * kBeams;
      const int here = int(std::min<std::size_t>(kBeams, count - at));
      rows.load_from(at, here);
      for (std::size_t g = first; g <= last; ++g) {
        if (!is_mine(g)) continue;
        const Cylinder& grid = *grids[g];
        CylinderTracer& tracer = *tracers[g - first];
        to_beams(rows.origins, rows.ends, grid.x, grid.y, grid.z, tracer.beams(), here);
        tracer.trace(here);
      }
    }
    for (std::size_t g = first; g <= last; ++g) {
      mark_cells(*tracers[g - first], grids[g]->shape, value, states + g * grids[g]->shape.cells());
    }
  };
  parallel_for(grids.size() * blocks, threads, kBeamsPerThread / kBeams, work);
  return 0;
}

}  // namespace circumspect
