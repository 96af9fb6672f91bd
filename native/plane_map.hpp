// A scene of points with normals, and the point-to-plane problem of a scan in it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cell_table.hpp"

namespace circumspect {

constexpr double kFarthest = 1e6;  // [m]; coordinates beyond are no part of any scene

struct Plane {
  double x, y, z, nx, ny, nz, variance, slope, unevenness;
};

// What the robust weights and the figures about a fit depend on; see registration.py.
struct FitRules {
  double reach, tukey, correlation, least_spread, uneven, least_cut, floor, far, averted;
  int64_t standing, fewest;
};

// The problem linear about one pose, and how well scan and scene agree there.
struct LinearFit {
  std::array<double, 36> hessian{};
  std::array<double, 36> feigned{};
  std::array<double, 6> gradient{};
  int64_t inliers = 0;
  double overlap = 0.0, distance = 0.0, residual = 0.0, misfit = 0.0;
};

// Planes in cubic cells, found by a hash of the cell.
class PlaneMap {
 public:
  // Rows of (n, 3) points and normals, n standard deviations, n variances of the normals' slopes,
  // and n of the points across their planes by what the surface shows there.
  PlaneMap(const double* points_xyz, const double* normals_xyz, const double* sigmas,
           const double* slopes, const double* unevenness, std::size_t count, double cell);

  // Of the planes that a camera can see, those whose normals make a cosine below `averted` with
  // its line of sight, the one nearest to a point and nearer than √`within2`, or null; sets
  // `within2` to its squared distance.
  const Plane* nearest(double x, double y, double z, const std::array<double, 3>& camera,
                       double averted, double& within2) const;

  // A scan's n points and standard deviations, placed by the first three rows of a 4 x 4 pose.
  LinearFit linearised(const double* points_xyz, const double* sigmas, std::size_t count,
                       const double* pose, const FitRules& rules) const;

 private:
  double cell_;
  CellTable cells_;
  std::vector<Plane> planes_;
};

}  // namespace circumspect
