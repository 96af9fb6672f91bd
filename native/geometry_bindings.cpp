// Python's view of the kernels of geometry. Sizes are checked here, so that no argument can make a
// kernel read or write outside its arrays.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "extent.hpp"
#include "face_normals.hpp"
#include "given.hpp"
#include "short_edges.hpp"

namespace nb = nanobind;
using namespace circumspect;

namespace {

using Points = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Faces = nb::ndarray<const int64_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Values = nb::ndarray<nb::numpy, double>;
using OutFaces = nb::ndarray<nb::numpy, int64_t, nb::shape<-1, 3>>;

void require(bool fulfilled, const char* message) {
  if (!fulfilled) throw std::invalid_argument(message);
}

Cloud cloud_of(const Points& points) {
  require(points.shape(0) >= 2, "two points");
  require(points.shape(0) < std::size_t(std::numeric_limits<int32_t>::max()), "fewer points");
  return {points.data(), points.shape(0)};
}

double spacing_of(Points points_xyz) {
  const Cloud cloud = cloud_of(points_xyz);
  nb::gil_scoped_release release;
  return spacing(cloud);
}

OutFaces faces_of(Points points_xyz, std::size_t neighbours, double reach) {
  require(neighbours >= 1, "one neighbour or more");
  require(reach > 0.0 && reach < std::numeric_limits<double>::infinity(), "a positive reach");
  const Cloud cloud = cloud_of(points_xyz);
  std::vector<int64_t> faces;
  {
    nb::gil_scoped_release release;
    faces = short_edge_faces(cloud, {neighbours, reach});
  }
  const std::size_t count = faces.size() / 3;
  return given<OutFaces>(std::move(faces), {count, 3});
}

nb::tuple normals_of(Points vertices_xyz, Faces faces) {
  const std::size_t count = faces.shape(0);
  const auto vertices = static_cast<int64_t>(vertices_xyz.shape(0));
  for (std::size_t n = 0; n < 3 * count; ++n) {
    require(faces.data()[n] >= 0 && faces.data()[n] < vertices, "corners that are vertices");
  }
  FaceNormals found;
  {
    nb::gil_scoped_release release;
    found = face_normals(vertices_xyz.data(), vertices_xyz.shape(0), faces.data(), count);
  }
  return nb::make_tuple(given<Values>(std::move(found.normals_xyz), {count, 3}),
                        given<Values>(std::move(found.doubled_areas), {count}), found.longest);
}

nb::tuple extent_of(Points points_xyz) {
  require(points_xyz.shape(0) >= 1, "a point");
  Extent found;
  {
    nb::gil_scoped_release release;
    found = extent(points_xyz.data(), points_xyz.shape(0));
  }
  const auto vector = [](const auto& values, std::initializer_list<std::size_t> shape) {
    return given<Values>(std::vector<double>(values.begin(), values.end()), shape);
  };
  return nb::make_tuple(vector(found.low, {3}), vector(found.high, {3}),
                        vector(found.scatter, {3, 3}));
}

}  // namespace

NB_MODULE(_native, m) {
  using namespace nb::literals;
  m.doc() = "Native kernels of geometry.";
  m.def("extent", &extent_of, "points_xyz"_a);
  m.def("face_normals", &normals_of, "vertices_xyz"_a, "faces"_a);
  m.def("short_edge_faces", &faces_of, "points_xyz"_a, "neighbours"_a, "reach"_a);
  m.def("spacing", &spacing_of, "points_xyz"_a);
}
