// Python's view of the kernels of geometry. Sizes are checked here, so that no argument can make a
// kernel read or write outside its arrays.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "extent.hpp"
#include "face_normals.hpp"
#include "given.hpp"
#include "groups.hpp"
#include "short_edges.hpp"

namespace nb = nanobind;
using namespace circumspect;

namespace {

using Points = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Faces = nb::ndarray<const int64_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Values = nb::ndarray<nb::numpy, double>;
using OutFaces = nb::ndarray<nb::numpy, int64_t, nb::shape<-1, 3>>;
using Keys = nb::ndarray<const int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Whole = nb::ndarray<nb::numpy, int64_t, nb::ndim<1>>;
template <typename T>
using Rows = nb::ndarray<const T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
template <typename T>
using Corners = nb::ndarray<const T, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

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

nb::tuple groups_of(Keys keys) {
  Groups found;
  {
    nb::gil_scoped_release release;
    found = group(keys.data(), keys.shape(0));
  }
  const std::size_t count = found.keys.size();
  return nb::make_tuple(given<Whole>(std::move(found.keys), {count}),
                        given<Whole>(std::move(found.first), {count}),
                        given<Whole>(std::move(found.of_row), {keys.shape(0)}));
}

Whole group_sizes_of(Keys keys) {
  std::vector<int64_t> found;
  {
    nb::gil_scoped_release release;
    found = group_sizes(keys.data(), keys.shape(0));
  }
  return given<Whole>(std::move(found), {keys.shape(0)});
}

Values split_means_of(Keys table_keys, Rows<double> totals, Keys keys) {
  require(totals.shape(0) == table_keys.shape(0) && totals.shape(1) == 2, "sum and count per key");
  std::vector<double> found;
  {
    nb::gil_scoped_release release;
    const Table table{table_keys.data(), totals.data(), table_keys.shape(0)};
    found = split_means(table, keys.data(), keys.shape(0));
  }
  return given<Values>(std::move(found), {keys.shape(0)});
}

template <typename T>
nb::tuple row_sums(Keys keys, Rows<T> values) {
  const std::size_t columns = values.shape(1);
  require(values.shape(0) == keys.shape(0), "one row per key");
  Groups found;
  std::vector<double> totals;
  {
    nb::gil_scoped_release release;
    found = group(keys.data(), keys.shape(0));
    totals.assign(found.keys.size() * columns, 0.0);
    add_rows(found.of_row.data(), values.data(), keys.shape(0), columns, totals.data());
  }
  const std::size_t count = found.keys.size();
  return nb::make_tuple(given<Whole>(std::move(found.keys), {count}),
                        given<Values>(std::move(totals), {count, columns}));
}

template <typename T>
Whole packed_cells(Corners<T> points_xyz, double side, int bits, int64_t offset) {
  require(side > 0.0 && bits >= 1 && bits <= 20, "side and bits");
  const Packing packing{side, bits, offset};
  const std::size_t count = points_xyz.shape(0);
  std::vector<int64_t> keys(count);
  {
    nb::gil_scoped_release release;
    pack_cells(points_xyz.data(), count, packing, keys.data());
  }
  return given<Whole>(std::move(keys), {count});
}

// Keys of surface patches: the cell, and the signed axis nearest to the normal.
template <typename T>
Whole patch_keys(Keys cells, Corners<T> normals_xyz) {
  const std::size_t count = cells.shape(0);
  require(normals_xyz.shape(0) == count, "one normal per cell");
  std::vector<int64_t> keys(count);
  {
    nb::gil_scoped_release release;
    for (std::size_t n = 0; n < count; ++n) {
      const T* v = normals_xyz.data() + 3 * n;
      int axis = std::fabs(v[1]) > std::fabs(v[0]);
      if (std::fabs(v[2]) > std::fabs(v[axis])) axis = 2;
      keys[n] = cells.data()[n] * 8 + 2 * axis + (v[axis] > T(0));
    }
  }
  return given<Whole>(std::move(keys), {count});
}

nb::tuple table_sum(Keys one_keys, Rows<double> one, Keys other_keys, Rows<double> other) {
  const std::size_t columns = one.shape(1);
  require(one.shape(0) == one_keys.shape(0) && other.shape(0) == other_keys.shape(0) &&
              other.shape(1) == columns,
          "one row per key and equal numbers of columns");
  MergedTable sum;
  {
    nb::gil_scoped_release release;
    sum = merged({one_keys.data(), one.data(), one.shape(0)},
                 {other_keys.data(), other.data(), other.shape(0)}, columns);
  }
  const std::size_t count = sum.keys.size();
  return nb::make_tuple(given<Whole>(std::move(sum.keys), {count}),
                        given<Values>(std::move(sum.totals), {count, columns}));
}

}  // namespace

NB_MODULE(_native, m) {
  using namespace nb::literals;
  m.doc() = "Native kernels of geometry.";
  m.def("extent", &extent_of, "points_xyz"_a);
  m.def("face_normals", &normals_of, "vertices_xyz"_a, "faces"_a);
  m.def("short_edge_faces", &faces_of, "points_xyz"_a, "neighbours"_a, "reach"_a);
  m.def("spacing", &spacing_of, "points_xyz"_a);
  m.def("groups", &groups_of, "keys"_a);
  m.def("group_sizes", &group_sizes_of, "keys"_a);
  m.def("split_means", &split_means_of, "table_keys"_a, "totals"_a, "keys"_a);
  m.def("row_sums", &row_sums<double>, "keys"_a, "values"_a);
  m.def("row_sums", &row_sums<float>, "keys"_a, "values"_a);
  m.def("packed_cells", &packed_cells<double>, "points_xyz"_a, "side"_a, "bits"_a, "offset"_a);
  m.def("packed_cells", &packed_cells<float>, "points_xyz"_a, "side"_a, "bits"_a, "offset"_a);
  m.def("patch_keys", &patch_keys<double>, "cells"_a, "normals_xyz"_a);
  m.def("patch_keys", &patch_keys<float>, "cells"_a, "normals_xyz"_a);
  m.def("table_sum", &table_sum, "one_keys"_a, "one"_a, "other_keys"_a, "other"_a);
}
