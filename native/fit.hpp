// Where the bounds of an object lie: its weighted centre, and how far its points are from there.
#pragma once

#include <array>
#include <cstddef>

namespace circumspect {

// Of (count, 3) points, at least one: the weighted mean, and the bounds along each axis.
struct WeightedCentre {
  std::array<double, 3> centre, low, high;
};

// Weights sum to 1; null means that all are alike. Sums are pairwise and relative to the first
// point, so that few digits are lost; the centre is within the bounds.
WeightedCentre weighted_centre(const double* points_xyz, const double* weights, std::size_t count);

// The largest distances from a vertical axis, and along x, y and z, x and y being turned.
struct Reach {
  double radius, x, y, z;
};

Reach reach(const double* points_xyz, std::size_t count, const std::array<double, 3>& centre,
            double cosine, double sine);

}  // namespace circumspect
