// How far points reach, and how they are spread.
#pragma once

#include <array>
#include <cstddef>

namespace circumspect {

// Bounds of (count, 3) points, at least one, and the sum of (p - mean)(p - mean)ᵀ in units of the
// longest side of the bounds (zero where that is).
struct Extent {
  std::array<double, 3> low, high;
  std::array<double, 9> scatter{};
};

Extent extent(const double* points_xyz, std::size_t count);

}  // namespace circumspect
