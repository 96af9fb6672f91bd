// Normals and areas of triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace circumspect {

// Of (n, 3) faces: unit normals, zero where there is none, and twice their areas in units of
// `longest`², which is the longest extent of an edge along an axis, so that no scale is too small
// or too large.
struct FaceNormals {
  std::vector<double> normals_xyz, doubled_areas;
  double longest;
};

FaceNormals face_normals(const double* vertices_xyz, std::size_t vertices, const int64_t* faces,
                         std::size_t count);

}  // namespace circumspect
