// Depth images: means over blocks, pixels on surfaces, pixels that stand on the floor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace circumspect {

struct Size {
  std::size_t height, width;
};

// Standard deviation of a depth z [m]: axial a + b (z - c)², and reported in steps of `step` z².
struct Noise {
  float a, b, c, step;
  float axial(float z) const { return a + b * ((z - c) * (z - c)); }
};

// A plane's height above each pixel: depth times (x u + y v + z), plus `height`, with u and v
// through the camera's focal lengths and principal point.
struct Rise {
  float x, y, z, height, fx, fy, cx, cy;
};

// Means of the inverse depth over blocks; `mask` may be null. A block is empty (NaN, 0) where its
// inverse depths differ by more than twice the share `jump`.
void block_means(const float* depth, const bool* mask, Size size, std::size_t block, float jump,
                 float* mean, int32_t* counts);

// Pixels that continue to a neighbour along rows and to one along columns: those no further in
// depth than `spreads` standard deviations and a step, or than a surface of slope `slope`
// continues.
void continuous(const float* depth, Size size, const Noise& noise, float spreads, float slope,
                bool* out);

// Takes those pixels out of a mask that are beyond `farthest`, or not higher above a plane than
// `margin` and `sigmas` standard deviations.
void keep_above(const float* depth, Size size, const Rise& rise, const Noise& noise, float margin,
                float sigmas, float farthest, bool* mask);

// The masked pixels' points in plan view, in square cells. Square blocks of pixels count as their
// first masked pixel.
struct PlanCells {
  std::vector<int32_t> cell;    // of each block with masked pixels, row by row: i * columns + j
  std::vector<int64_t> counts;  // pixels of each cell
  double low_x = 0.0, low_y = 0.0;
  std::size_t rows = 0, columns = 0;
};

// `pose` holds the rows of a 4 x 4 matrix; cells begin two below the lowest point. Empty where
// the points need more than `most` cells, or the first masked pixel of a block has no depth.
PlanCells plan_cells(const float* depth, const bool* mask, Size size, const double* camera,
                     const double* pose, double cell, std::size_t most, std::size_t block);

// Number of blocks with masked pixels.
std::size_t masked_blocks(const bool* mask, Size size, std::size_t block);

// Takes those blocks out of a mask whose cells, as `plan_cells` found them, are not wanted.
void keep_cells(const int32_t* cell, const bool* wanted, Size size, std::size_t block, bool* mask);

}  // namespace circumspect
