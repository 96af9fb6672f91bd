// The cylindrical grid: which cell holds a point.
#pragma once

#include <vector>

#include "block.hpp"

namespace circumspect {

struct Direction {
  double x, y;
};

struct Cylinder {
  Shape shape;  // cells along (radius, azimuth, height)
  double radius, half_height;
  double x, y, z;        // centre
  double azimuth_offset; // in [0, 2 pi)
  // The half-planes between the sectors, first repeated at the end. They decide where a point
  // lies; a quarter turn maps them onto each other exactly when 4 divides their number.
  std::vector<Direction> sectors;

  Cylinder(Shape shape, double radius, double half_height, double x, double y, double z,
           double azimuth_offset);

  // Cells of the first `count` points of a block. Points on the outer boundary are inside.
  void locate(Block& block, int count) const;

  // The sector of a direction, known to lie close to half-plane `nearest`, 0 … shape.j.
  int32_t sector_beside(int32_t nearest, double dx, double dy) const {
    const Direction& d = sectors[std::size_t(nearest)];
    const bool behind = d.x * dy - d.y * dx < 0.0;
    const int32_t sector = behind ? nearest - 1 : nearest;
    return sector < 0 ? shape.j - 1 : (sector >= shape.j ? 0 : sector);
  }
};

}  // namespace circumspect
