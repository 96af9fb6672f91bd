// The surface that the masked pixels of a depth image show.
#pragma once

#include <cstddef>
#include <vector>

#include "depth_image.hpp"

namespace circumspect {

// See frame_surface.py for the meaning of the settings.
struct FrameSurfaceSettings {
  double fx, fy, cx, cy;
  Noise noise;
  std::size_t point_block, normal_block;  // the latter a multiple of the former
  float jump;
  double min_incidence_cosine;
};

// Rows of points and normals in the frame of `pose`, and an area and a weight for each.
struct FrameSurface {
  std::vector<double> points_xyz;
  std::vector<float> normals_xyz, areas, weights;
};

// `pose` holds the rows of a 4 x 4 matrix.
FrameSurface frame_surface(const float* depth, const bool* mask, Size size, const double* pose,
                           const FrameSurfaceSettings& settings);

}  // namespace circumspect
