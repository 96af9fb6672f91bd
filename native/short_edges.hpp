// Triangles between near neighbours of a cloud.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace circumspect {

// (n, 3) points of an extent near 1, at least two, no two in one place.
struct Cloud {
  const double* points_xyz;
  std::size_t count;
};

// How near two corners of a triangle are: among the nearest `neighbours` of the third, and within
// `reach` spacings.
struct NearRules {
  std::size_t neighbours;
  double reach;
};

// The typical distance from a point to the nearest one that is not in the same cluster: the median
// distance to the nearest neighbour, unless the medians to the second, third, … neighbour jump;
// then it is the one behind the last jump. On thin walls the nearest neighbour is the point on the
// other side, and its distance the thickness of the wall.
double spacing(const Cloud& cloud);

// Triangles of a point and two of its nearest, all within reach of each other: rows of three
// corners, in ascending order, each once.
std::vector<int64_t> short_edge_faces(const Cloud& cloud, const NearRules& rules);

}  // namespace circumspect
