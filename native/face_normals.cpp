#include "face_normals.hpp"

#include <algorithm>
#include <cmath>

namespace circumspect {
namespace {

double longest_extent(const double* vertices_xyz, const int64_t* faces, std::size_t count) {
  double longest = 0.0;
  for (std::size_t n = 0; n < count; ++n) {
    const double* corner[3];
    for (std::size_t c = 0; c < 3; ++c) corner[c] = vertices_xyz + 3 * faces[3 * n + c];
    for (std::size_t a = 0; a < 3; ++a) {
      const double x = corner[0][a], y = corner[1][a], z = corner[2][a];
      longest = std::max(longest, std::max({x, y, z}) - std::min({x, y, z}));
    }
  }
  return longest;
}

}  // namespace

FaceNormals face_normals(const double* vertices_xyz, std::size_t vertices, const int64_t* faces,
                         std::size_t count) {
  FaceNormals found{std::vector<double>(3 * count), std::vector<double>(count),
                    longest_extent(vertices_xyz, faces, count)};
  if (!(found.longest > 0.0)) return found;
  std::vector<double> scaled(vertices_xyz, vertices_xyz + 3 * vertices);
  for (double& value : scaled) value /= found.longest;
  for (std::size_t n = 0; n < count; ++n) {
    const double* a = scaled.data() + 3 * faces[3 * n];
    const double* b = scaled.data() + 3 * faces[3 * n + 1];
    const double* c = scaled.data() + 3 * faces[3 * n + 2];
    const double px = b[0] - a[0], py = b[1] - a[1], pz = b[2] - a[2];
    const double qx = c[0] - a[0], qy = c[1] - a[1], qz = c[2] - a[2];
    const double x = py * qz - pz * qy, y = pz * qx - px * qz, z = px * qy - py * qx;
    const double doubled = std::sqrt(x * x + y * y + z * z);
    found.doubled_areas[n] = doubled;
    if (!(doubled > 0.0)) continue;
    double* normal = found.normals_xyz.data() + 3 * n;
    normal[0] = x / doubled, normal[1] = y / doubled, normal[2] = z / doubled;
  }
  return found;
}

}  // namespace circumspect
