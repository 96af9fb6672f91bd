// Python's view of the kernels of reconstruction. Sizes are checked here, so that no argument can
// make a kernel read or write outside its arrays.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/tuple.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "frame_surface.hpp"
#include "given.hpp"
#include "groups.hpp"
#include "merged_rays.hpp"

namespace nb = nanobind;
using namespace circumspect;

namespace {

template <typename T>
using Triples = nb::ndarray<const T, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Keys = nb::ndarray<const int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Weights = nb::ndarray<const float, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Flags = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Image = nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Mask = nb::ndarray<const bool, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Pose = nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu>;
using Quadruple = std::tuple<double, double, double, double>;
using Noises = std::tuple<float, float, float, float>;
using OutKeys = nb::ndarray<nb::numpy, int64_t, nb::ndim<1>>;
using OutFloats = nb::ndarray<nb::numpy, float>;
using OutDoubles = nb::ndarray<nb::numpy, double>;
using OutFlags = nb::ndarray<nb::numpy, bool, nb::ndim<1>>;

void require(bool fulfilled, const char* message) {
  if (!fulfilled) throw std::invalid_argument(message);
}

nb::tuple surface_of_frame(Image depth, Mask mask, Quadruple camera, Pose pose, Noises noise,
                           std::size_t point_block, std::size_t normal_block, float jump,
                           double min_incidence_cosine) {
  require(mask.shape(0) == depth.shape(0) && mask.shape(1) == depth.shape(1),
          "a mask of the image's size");
  require(point_block >= 1 && normal_block <= 4096 && normal_block >= point_block &&
              normal_block % point_block == 0,
          "blocks");
  const auto [fx, fy, cx, cy] = camera;
  const auto [a, b, c, step] = noise;
  FrameSurface found;
  {
    nb::gil_scoped_release release;
    found = frame_surface(
        depth.data(), mask.data(), {depth.shape(0), depth.shape(1)}, pose.data(),
        {fx, fy, cx, cy, {a, b, c, step}, point_block, normal_block, jump, min_incidence_cosine});
  }
  const std::size_t count = found.areas.size();
  return nb::make_tuple(given<OutDoubles>(std::move(found.points_xyz), {count, 3}),
                        given<OutFloats>(std::move(found.normals_xyz), {count, 3}),
                        given<OutFloats>(std::move(found.areas), {count}),
                        given<OutFloats>(std::move(found.weights), {count}));
}

// Sums per voxel of weight, weighted point and weighted normal, and a frame count of one.
nb::tuple surface_sums(Triples<double> points_xyz, Triples<float> normals_xyz, Weights weights,
                       Keys keys) {
  const std::size_t count = points_xyz.shape(0), columns = 8;
  require(normals_xyz.shape(0) == count && weights.shape(0) == count && keys.shape(0) == count,
          "one normal, weight and key per point");
  Groups found;
  std::vector<double> totals;
  {
    nb::gil_scoped_release release;
    found = group(keys.data(), count);
    totals.assign(found.keys.size() * columns, 0.0);
    for (std::size_t n = 0; n < count; ++n) {
      double* row = totals.data() + columns * std::size_t(found.of_row[n]);
      const double weight = double(weights.data()[n]);
      row[0] += weight, row[7] = 1.0;
      for (std::size_t a = 0; a < 3; ++a) {
        row[1 + a] += points_xyz.data()[3 * n + a] * weight;
        row[4 + a] += double(normals_xyz.data()[3 * n + a]) * weight;
      }
    }
  }
  const std::size_t voxels = found.keys.size();
  return nb::make_tuple(given<OutKeys>(std::move(found.keys), {voxels}),
                        given<OutDoubles>(std::move(totals), {voxels, columns}));
}

// Mean points and unit normals of rows of such sums; the normal (0, 0, 1) where the sum is zero.
nb::tuple surface_means(Rows totals) {
  const std::size_t count = totals.shape(0), columns = totals.shape(1);
  require(columns >= 7, "weight, point and normal");
  std::vector<double> points(3 * count), normals(3 * count);
  {
    nb::gil_scoped_release release;
    for (std::size_t n = 0; n < count; ++n) {
      const double* row = totals.data() + columns * n;
      const double length = std::sqrt(row[4] * row[4] + row[5] * row[5] + row[6] * row[6]);
      for (std::size_t a = 0; a < 3; ++a) {
        points[3 * n + a] = row[1 + a] / row[0];
        normals[3 * n + a] = length > 1e-9 ? row[4 + a] / length : double(a == 2);
      }
    }
  }
  return nb::make_tuple(given<OutDoubles>(std::move(points), {count, 3}),
                        given<OutDoubles>(std::move(normals), {count, 3}));
}

nb::tuple merge_rays(Keys keys, Triples<float> origins_xyz, Triples<float> ends_xyz,
                     Flags on_object, Keys more_keys, Triples<float> more_origins_xyz,
                     Triples<float> more_ends_xyz, Flags more_on_object) {
  const auto checked = [](const Keys& k, const Triples<float>& o, const Triples<float>& e,
                          const Flags& f) {
    require(o.shape(0) == k.shape(0) && e.shape(0) == k.shape(0) && f.shape(0) == k.shape(0),
            "one origin, end and flag per key");
    return Rays{k.data(), o.data(), e.data(), f.data(), k.shape(0)};
  };
  const Rays one = checked(keys, origins_xyz, ends_xyz, on_object);
  const Rays other = checked(more_keys, more_origins_xyz, more_ends_xyz, more_on_object);
  const std::size_t room = one.count + other.count;
  std::vector<int64_t> all(room);
  std::vector<float> origins(3 * room), ends(3 * room);
  auto* flags = new bool[room + 1];
  nb::capsule owner(flags, [](void* p) noexcept { delete[] static_cast<bool*>(p); });
  std::size_t count = 0;
  {
    nb::gil_scoped_release release;
    count = merged_rays(one, other, {all.data(), origins.data(), ends.data(), flags});
  }
  return nb::make_tuple(
      given<OutKeys>(std::move(all), {count}), given<OutFloats>(std::move(origins), {count, 3}),
      given<OutFloats>(std::move(ends), {count, 3}), OutFlags(flags, {count}, owner));
}

nb::object added_keys_of(Keys known, Keys all) {
  std::vector<int64_t> rows;
  bool contained = false;
  {
    nb::gil_scoped_release release;
    contained = added_keys(known.data(), known.shape(0), all.data(), all.shape(0), rows);
  }
  if (!contained) return nb::none();
  const std::size_t count = rows.size();
  return nb::cast(given<OutKeys>(std::move(rows), {count}));
}

}  // namespace

NB_MODULE(_native, m) {
  using namespace nb::literals;
  m.doc() = "Native kernels of reconstruction.";
  m.def("frame_surface", &surface_of_frame, "depth"_a, "mask"_a, "camera"_a, "pose"_a, "noise"_a,
        "point_block"_a, "normal_block"_a, "jump"_a, "min_incidence_cosine"_a);
  m.def("surface_sums", &surface_sums, "points_xyz"_a, "normals_xyz"_a, "weights"_a, "keys"_a);
  m.def("surface_means", &surface_means, "totals"_a);
  m.def("merge_rays", &merge_rays, "keys"_a, "origins_xyz"_a, "ends_xyz"_a, "on_object"_a,
        "more_keys"_a, "more_origins_xyz"_a, "more_ends_xyz"_a, "more_on_object"_a);
  m.def("added_keys", &added_keys_of, "known"_a, "keys"_a);
}
