#include "frame_surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace circumspect {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Blocks {
  std::size_t rows, columns, block;
  std::vector<float> inverse_depth;
  std::vector<int32_t> counts;

  Blocks(const float* depth, const bool* mask, Size size, std::size_t side, float jump)
      : rows((size.height + side - 1) / side), columns((size.width + side - 1) / side), block(side),
        inverse_depth(rows * columns), counts(rows * columns) {
    block_means(depth, mask, size, side, jump, inverse_depth.data(), counts.data());
  }

  double at(std::size_t row, std::size_t column) const {
    return double(inverse_depth[row * columns + column]);
  }
  double middle(std::size_t index) const { return double(index * block) + (double(block) - 1) / 2; }
};

// Mean change from one neighbour to the next, of those that are on the same surface, or NaN.
double slope(double before, double here, double after, double jump, double block) {
  double sum = 0.0;
  int count = 0;
  const auto add = [&](double from, double to) {
    const double step = to - from;
    if (std::fabs(step) <= jump * std::max(from, to)) sum += step, ++count;
  };
  add(before, here);
  add(here, after);
  return count > 0 ? sum / count / block : kNone;
}

// Unit vectors towards the camera, three a block; NaN where unknown.
std::vector<double> block_normals(const Blocks& b, const FrameSurfaceSettings& s) {
  std::vector<double> normals(3 * b.rows * b.columns, kNone);
  for (std::size_t row = 0; row < b.rows; ++row) {
    const double v = b.middle(row) - s.cy;
    for (std::size_t column = 0; column < b.columns; ++column) {
      const double q = b.at(row, column);
      if (std::isnan(q)) continue;
      const double u = b.middle(column) - s.cx, block = double(b.block);
      const double along_row =
          slope(column > 0 ? b.at(row, column - 1) : kNone, q,
                column + 1 < b.columns ? b.at(row, column + 1) : kNone, s.jump, block);
      const double along_column =
          slope(row > 0 ? b.at(row - 1, column) : kNone, q,
                row + 1 < b.rows ? b.at(row + 1, column) : kNone, s.jump, block);
      const double x = along_row * s.fx, y = along_column * s.fy;
      const double z = q - along_row * u - along_column * v;
      const double length = std::sqrt(x * x + y * y + z * z);
      double* normal = &normals[3 * (row * b.columns + column)];
      normal[0] = -x / length, normal[1] = -y / length, normal[2] = -z / length;
    }
  }
  return normals;
}

}  // namespace

FrameSurface frame_surface(const float* depth, const bool* mask, Size size, const double* pose,
                           const FrameSurfaceSettings& s) {
  const Blocks fine(depth, mask, size, s.point_block, s.jump);
  const Blocks coarse(depth, mask, size, s.normal_block, s.jump);
  const std::vector<double> normals = block_normals(coarse, s);
  const std::size_t ratio = s.normal_block / s.point_block;
  FrameSurface found;
  const std::size_t count = std::size_t(
      std::count_if(fine.counts.begin(), fine.counts.end(), [](int32_t n) { return n > 0; }));
  found.points_xyz.reserve(3 * count), found.normals_xyz.reserve(3 * count);
  found.areas.reserve(count), found.weights.reserve(count);
  for (std::size_t row = 0; row < fine.rows; ++row) {
    const double b = (fine.middle(row) - s.cy) / s.fy;
    for (std::size_t column = 0; column < fine.columns; ++column) {
      const int32_t pixels = fine.counts[row * fine.columns + column];
      if (pixels == 0) continue;
      const double z = 1.0 / fine.at(row, column), a = (fine.middle(column) - s.cx) / s.fx;
      const double per_distance = 1.0 / std::sqrt(a * a + b * b + 1.0);
      const double towards[3] = {-a * per_distance, -b * per_distance, -per_distance};
      const double* known = &normals[3 * (row / ratio * coarse.columns + column / ratio)];
      const double* normal = std::isfinite(known[0]) ? known : towards;
      const double along = normal[0] * towards[0] + normal[1] * towards[1] + normal[2] * towards[2];
      const double cosine = std::max(along, s.min_incidence_cosine);
      // The area of a pixel perpendicular to its ray shrinks with the ray's angle to the axis.
      const double facing = per_distance * z * z / (s.fx * s.fy) * pixels;
      const double sigma = double(s.noise.axial(float(z)));
      for (int k = 0; k < 3; ++k) {
        const double* T = pose + 4 * k;
        found.points_xyz.push_back((T[0] * a + T[1] * b + T[2]) * z + T[3]);
        found.normals_xyz.push_back(float(T[0] * normal[0] + T[1] * normal[1] + T[2] * normal[2]));
      }
      found.areas.push_back(float(facing / cosine));
      found.weights.push_back(float(cosine / (sigma * sigma)));
    }
  }
  return found;
}

}  // namespace circumspect
