// The rectangular grid, a cube: which cell holds a point.
#pragma once

#include "block.hpp"

namespace circumspect {

struct Box {
  Shape shape;  // cells along (x, y, z) of the cube
  double half_width;
  double x, y, z;       // centre
  double cosine, sine;  // of the yaw of the cube

  // Cells of the first `count` points of a block. Points on the outer boundary are inside.
  void locate(Block& block, int count) const;
};

}  // namespace circumspect
