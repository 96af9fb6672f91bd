// Principal components of the surroundings of points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace circumspect {

// The direction in which points vary least, and variances in ascending order.
struct PlaneFit {
  std::array<double, 3> normal;
  std::array<double, 3> variances;
};

// Of `count` points, rows of (n, 3), whose numbers are given; count >= 1.
PlaneFit plane_fit(const double* points_xyz, const int64_t* numbers, std::size_t count);

}  // namespace circumspect
