// The cylindrical grid: which cell holds a point.
#pragma once

#include <vector>

#include "block.hpp"

namespace circumspect {

// Unit vectors from the axis.
struct HalfPlanes {
  std::vector<double> x, y;
};

struct Cylinder {
  Shape shape;  // cells along (radius, azimuth, height)
  double radius, half_height;
  double x, y, z;         // centre
  double azimuth_offset;  // in [0, 2 pi)
  // The half-planes between the sectors decide where a point lies; a quarter turn maps them onto
  // each other exactly when 4 divides their number. Number 0, 1, 2, … and number 0, -1, -2, …
  HalfPlanes forward, backward;

  Cylinder(Shape shape, double radius, double half_height, double x, double y, double z,
           double azimuth_offset);

  // Cells of the first `count` points of a block. Points on the outer boundary are inside.
  void locate(Block& block, int count) const;

  // The same for one point about the centre, in double precision throughout.
  Cell cell_of(double x_about, double y_about, double z_about) const;

  // The sector of a direction from the axis.
  int32_t sector_of(double x_about, double y_about) const;
};

}  // namespace circumspect
