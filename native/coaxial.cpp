#include "coaxial.hpp"

#include <algorithm>
#include <cmath>

#include "azimuth.hpp"
#include "hits.hpp"
#include "multiversion.hpp"

namespace circumspect {
namespace {

constexpr int32_t kDoubtful = -2;  // -1 is outside

// What is beyond the outer boundary by more is outside, in parts of an axis: less than `kDoubt`, so
// that nothing between is sure to be in a cell, and more than rounding.
constexpr float kBeyond = 1.2e-6f;
static_assert(kBeyond < 0.9f * kDoubt, "cells would lie outside of the array");

// Single precision has no room for sizes whose ratio is larger, or for more cells.
constexpr double kMostRatio = 1e3;
constexpr std::size_t kMostCells = std::size_t(1) << 24;

constexpr float kMostRadius = 2.0f;  // in units of the largest radius

PolarScales scales_of(const Cylinder& grid, double unit, double above) {
  const Shape& shape = grid.shape;
  const double per_azimuth = shape.j / (2.0 * kPi);
  const double per_height = 0.5 * shape.k * (unit / grid.half_height);
  PolarScales s;
  s.rings = float(shape.i), s.sectors = float(shape.j), s.layers = float(shape.k);
  s.per_radius = float(shape.i * (unit / grid.radius));
  s.past_rings = s.rings * (1.0f + kBeyond);
  s.per_azimuth = float(per_azimuth);
  s.offset = float(grid.azimuth_offset * per_azimuth);
  s.per_height = float(per_height);
  s.middle = float(0.5 * shape.k - above / unit * per_height);
  s.below_layers = -kBeyond * s.layers, s.past_layers = s.layers * (1.0f + kBeyond);
  s.sure_ring = 0.5f - kDoubt * s.rings;
  s.sure_sector = 0.5f - kDoubt * s.sectors;
  s.sure_layer = 0.5f - kDoubt * s.layers;
  s.cells_of_sector = s.layers, s.cells_of_ring = s.sectors * s.layers;
  return s;
}

// About the axis and turned, still in double precision.
CIRCUMSPECT_MULTIVERSION
void turn(double x, double y, double cosine, double sine, Block& block, int count) {
  for (int n = 0; n < count; ++n) {
    const double along = block.x[n] - x, across = block.y[n] - y;
    block.x[n] = cosine * along - sine * across;
    block.y[n] = sine * along + cosine * across;
  }
}

CIRCUMSPECT_MULTIVERSION
void centre(double x, double y, Block& block, int count) {
  for (int n = 0; n < count; ++n) block.x[n] -= x;
  for (int n = 0; n < count; ++n) block.y[n] -= y;
}

// Limited to somewhat more than all grids, so that cells are whole numbers that fit; NaN too.
CIRCUMSPECT_MULTIVERSION
void to_polar(double z, double per_unit, float most_height, const Block& block, Polar& polar,
              int count) {
  for (int n = 0; n < count; ++n) {
    const float x = float(block.x[n] * per_unit), y = float(block.y[n] * per_unit);
    polar.radius[n] = clamped(std::sqrt(x * x + y * y), kMostRadius);
    polar.azimuth[n] = clamped(azimuth_of(x, y), float(2.0 * kPi));
    const float height = float((block.z[n] - z) * per_unit);
    const float up = height > -most_height ? height : -most_height;
    polar.height[n] = up < most_height ? up : most_height;
  }
}

// Cells in single precision, or `kDoubtful` for points so close to a boundary that they have to be
// looked at again. Whole numbers stay in single precision, where they are exact and quick.
CIRCUMSPECT_MULTIVERSION
void locate_roughly(const PolarScales& s, const Polar& polar, int32_t* __restrict cells,
                    int count) {
  const float all_sectors = s.sectors;  // read in any case: with a branch it is no vector code
  for (int n = 0; n < count; ++n) {
    const float i = polar.radius[n] * s.per_radius;
    const float turned = polar.azimuth[n] * s.per_azimuth - s.offset;
    const float j = turned + (turned < 0.0f ? all_sectors : 0.0f);
    const float k = polar.height[n] * s.per_height + s.middle;
    const float ring = float(int32_t(i)), sector = float(int32_t(j)), layer = float(int32_t(k));
    const int32_t outside = (i > s.past_rings) | (k < s.below_layers) | (k > s.past_layers);
    const int32_t sure = (std::fabs(i - ring - 0.5f) < s.sure_ring) &
                         (std::fabs(j - sector - 0.5f) < s.sure_sector) &
                         (std::fabs(k - layer - 0.5f) < s.sure_layer);
    const int32_t cell = int32_t(ring * s.cells_of_ring + sector * s.cells_of_sector + layer);
    // -1 outside, and one less where neither is sure.
    cells[n] = (cell | -outside | (sure - 1)) - (1 & ~(outside | sure));
  }
}

}  // namespace

Coaxial::Coaxial(const std::vector<const Cylinder*>& grids, double yaw)
    : x_(grids[0]->x), y_(grids[0]->y), z_(grids[0]->z), cosine_(yaw == 0.0 ? 1.0 : std::cos(yaw)),
      sine_(yaw == 0.0 ? 0.0 : std::sin(yaw)) {
  double unit = 0.0, height = 0.0;
  for (const Cylinder* grid : grids) {
    grids_.push_back(*grid);
    grids_.back().x = grids_.back().y = 0.0;
    unit = std::max(unit, grid->radius);
    height = std::max(height, grid->half_height);
  }
  per_unit_ = 1.0 / unit;
  most_height_ = float(4.0 * height * per_unit_);
  const auto fits = [&](const Cylinder& grid) {
    return grid.radius * kMostRatio >= unit && grid.half_height * kMostRatio >= unit &&
           grid.half_height <= unit * kMostRatio && grid.shape.cells() <= kMostCells &&
           std::fabs(grid.z - z_) <= grid.half_height;
  };
  if (!std::all_of(grids_.begin(), grids_.end(), fits)) return;
  for (const Cylinder& grid : grids_) scales_.push_back(scales_of(grid, unit, grid.z - z_));
}

void Coaxial::mark(Block& block, int count, uint8_t value, uint8_t* states) const {
  if (sine_ == 0.0 && cosine_ == 1.0) {
    centre(x_, y_, block, count);
  } else {
    turn(x_, y_, cosine_, sine_, block, count);
  }
  if (scales_.empty()) {
    for (const Cylinder& grid : grids_) {
      mark_one(grid, block, count, value, states);
      states += grid.shape.cells();
    }
    return;
  }
  Polar polar;
  to_polar(z_, per_unit_, most_height_, block, polar, count);
  alignas(64) int32_t cells[kBlock];
  for (std::size_t g = 0; g < grids_.size(); ++g) {
    const Cylinder& grid = grids_[g];
    locate_roughly(scales_[g], polar, cells, count);
    for (int n = 0; n < count; ++n) {
      if (cells[n] >= 0) {
        circumspect::mark(states + cells[n], value);
      } else if (cells[n] == kDoubtful) {
        const Cell cell = grid.cell_of(block.x[n], block.y[n], block.z[n] - grid.z);
        if (cell.i >= 0) circumspect::mark(states + grid.shape.number_of(cell), value);
      }
    }
    states += grid.shape.cells();
  }
}

void Coaxial::mark_one(const Cylinder& grid, Block& block, int count, uint8_t value,
                       uint8_t* states) const {
  grid.locate(block, count);
  for (int n = 0; n < count; ++n) {
    const Cell cell{block.i[n], block.j[n], block.k[n]};
    if (cell.i >= 0) circumspect::mark(states + grid.shape.number_of(cell), value);
  }
}

}  // namespace circumspect
