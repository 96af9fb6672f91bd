// A map of points with normals, and the point-to-plane problem of a scan in it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cell_table.hpp"

namespace circumspect {

constexpr double kFarthest = 1e6;  // [m]; points beyond are in no map

struct Plane {
  double x, y, z, nx, ny, nz, variance, normal_variance, roughness;
};

// Correspondences and weights; see point_to_plane.py.
struct FitSettings {
  double max_distance, tukey_cutoff, correlation_factor, min_noise_scale, roughness_factor,
      min_cutoff, max_floor_height, max_plane_distance, max_backface_cosine;
  int64_t min_points_off_floor, min_correspondences;
};

// The problem linearised at one pose, and how well scan and map agree there.
struct PointToPlaneProblem {
  std::array<double, 36> hessian{};
  std::array<double, 36> spurious{};
  std::array<double, 6> gradient{};
  int64_t inliers = 0;
  double overlap = 0.0, distance = 0.0, residual = 0.0, normalised_residual = 0.0;
};

// Planes in cubic cells, with a hash table of the cells.
class PlaneMap {
 public:
  // Rows of (n, 3) points and normals, n standard deviations, n variances of the normals' tilt,
  // and n variances of the points about their planes.
  PlaneMap(const double* points_xyz, const double* normals_xyz, const double* sigmas,
           const double* normal_variances, const double* roughness, std::size_t count, double cell);

  // The plane nearest to a point, nearer than √`within2` and visible from the camera, or null. A
  // plane is visible if the cosine between its normal and the line of sight is below
  // `max_backface_cosine`. Sets `within2` to the squared distance.
  const Plane* nearest(double x, double y, double z, const std::array<double, 3>& camera,
                       double max_backface_cosine, double& within2) const;

  // Row of the plane nearest to a point, as `nearest`, or -1.
  int64_t nearest_row(double x, double y, double z, const std::array<double, 3>& camera,
                      double max_distance, double max_backface_cosine) const;

  // A scan's n points with standard deviations and numbers of correlated points, placed by the
  // first three rows of a 4 x 4 pose.
  PointToPlaneProblem linearised(const double* points_xyz, const double* sigmas,
                                 const double* correlations, std::size_t count, const double* pose,
                                 const FitSettings& settings) const;

 private:
  double cell_;
  CellTable cells_;
  std::vector<Plane> planes_;
};

}  // namespace circumspect
