// Python's view of the kernels of geometry. Sizes are checked here, so that no argument can make a
// kernel read or write outside its arrays.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "face_normals.hpp"
#include "given.hpp"
#include "short_edges.hpp"

namespace nb = nanobind;
using namespace circumspect;

namespace {

using Points = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Faces = nb::ndarray<const int64_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Values = nb::ndarray<nb::numpy, double, nb::ndim<1>>;
using Vectors = nb::ndarray<nb::numpy, double, nb::shape<-1, 3>>;
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
  return nb::make_tuple(given<Vectors>(std::move(found.normals_xyz), {count, 3}),
                        given<Values>(std::move(found.doubled_areas), {count}), found.longest);
}

}  // namespace

NB_MODULE(_native, m) {
  using namespace nb::literals;
  m.doc() = "Native kernels of geometry.";
  m.def("face_normals", &normals_of, "vertices_xyz"_a, "faces"_a);
  m.def("short_edge_faces", &faces_of, "points_xyz"_a, "neighbours"_a, "reach"_a);
  m.def("spacing", &spacing_of, "points_xyz"_a);
}
