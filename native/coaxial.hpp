// Points into the cells of several cylinders about one axis: a point's radius and azimuth are found
// once for all of them.
#pragma once

#include <algorithm>
#include <atomic>
#include <vector>

#include "block.hpp"
#include "cylinder.hpp"
#include "hits.hpp"
#include "parallel.hpp"

namespace circumspect {

// Coordinates about the axis, in single precision.
struct Polar {
  alignas(64) float radius[kBlock];   // in units of the largest radius of all grids
  alignas(64) float azimuth[kBlock];  // [rad], 0 … 2 pi
  alignas(64) float height[kBlock];   // in the same units, above the centre of the first grid
};

// From `Polar` to the cells of one grid.
struct PolarScales {
  float per_radius, rings, past_rings;
  float per_azimuth, offset, sectors;
  float per_height, middle, layers, below_layers, past_layers;
  float sure_ring, sure_sector, sure_layer;  // largest distances from the middle of a cell
  float cells_of_sector, cells_of_ring;
};

// Points get the same cells as from `Cylinder::locate`: those near a border are located in double
// precision, as there.
class Coaxial {
 public:
  // Grids of one shape whose centres differ in height only. Points are turned about the axis by
  // `yaw` [rad] first.
  Coaxial(const std::vector<const Cylinder*>& grids, double yaw);

  // Writes `value` into each cell of every grid that holds one of the first `count` points; the
  // states of one grid follow those of another. Changes x and y of the block.
  void mark(Block& block, int count, uint8_t value, uint8_t* states) const;

 private:
  void mark_one(const Cylinder& grid, Block& block, int count, uint8_t value,
                uint8_t* states) const;

  std::vector<Cylinder> grids_;      // about x = y = 0
  std::vector<PolarScales> scales_;  // empty where the grids differ too much for single precision
  double x_, y_, z_, cosine_, sine_, per_unit_;
  float most_height_;
};

// Writes `value` into each cell of every grid that holds a point; returns how many points were not
// usable.
template <typename T>
int64_t mark_coaxial_hits(const Coaxial& grids, const T* points_xyz, std::size_t count,
                          uint8_t value, uint8_t* states, std::size_t threads) {
  std::atomic<int64_t> bad{0};
  parallel_for(count, threads, kPointsPerThread, [&](std::size_t begin, std::size_t end) {
    Block block;
    int64_t bad_here = 0;
    for (std::size_t at = begin; at < end; at += kBlock) {
      const int here = int(std::min<std::size_t>(kBlock, end - at));
      bad_here += load(points_xyz + 3 * at, here, block);
      grids.mark(block, here, value, states);
    }
    bad += bad_here;
  });
  return bad;
}

}  // namespace circumspect
