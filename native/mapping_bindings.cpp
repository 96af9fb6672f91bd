// Python's view of the kernels of mapping. Sizes are checked here, so that no argument can make a
// kernel read or write outside its arrays.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "given.hpp"
#include "groups.hpp"
#include "parallel.hpp"
#include "plane_fits.hpp"
#include "plane_map.hpp"

namespace nb = nanobind;
using namespace circumspect;

namespace {

using Points = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Values = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Pose = nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu>;
using Keys = nb::ndarray<const int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Whole = nb::ndarray<nb::numpy, int64_t, nb::ndim<1>>;
using Values32 = nb::ndarray<const float, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Single = nb::ndarray<nb::numpy, float>;
using Given = nb::ndarray<nb::numpy, bool, nb::ndim<1>>;
using Real = nb::ndarray<nb::numpy, double>;
template <typename T>
using Rows = nb::ndarray<const T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

constexpr std::size_t kPlanesPerThread = 500;  // fewer are fitted before a thread has started

void require(bool fulfilled, const char* message) {
  if (!fulfilled) throw std::invalid_argument(message);
}

PlaneMap* make_planes(Points points_xyz, Points normals_xyz, Values sigmas, Values slopes,
                      Values unevenness, double cell) {
  const std::size_t count = points_xyz.shape(0);
  require(normals_xyz.shape(0) == count && sigmas.shape(0) == count &&
              slopes.shape(0) == count && unevenness.shape(0) == count,
          "one normal, sigma, slope and unevenness a point");
  require(count < (std::size_t(1) << 30), "number of points");
  require(cell >= 1e-3 && cell <= 1e3, "cell");
  for (std::size_t n = 0; n < 3 * count; ++n) {
    require(std::fabs(points_xyz.data()[n]) < kFarthest, "points that are finite and within 1000 km");
  }
  nb::gil_scoped_release release;
  return new PlaneMap(points_xyz.data(), normals_xyz.data(), sigmas.data(), slopes.data(),
                      unevenness.data(), count, cell);
}

nb::tuple linearised(const PlaneMap& planes, Points points_xyz, Values sigmas, Pose pose,
                     double reach, double tukey, double correlation, double least_spread,
                     double uneven, double least_cut, double floor, double far, double averted,
                     int64_t standing, int64_t fewest) {
  require(sigmas.shape(0) == points_xyz.shape(0), "one sigma a point");
  require(reach > 0.0 && reach <= 10.0, "reach");
  const FitRules rules{reach, tukey, correlation, least_spread, uneven, least_cut,
                       floor, far,   averted,     standing,     fewest};
  LinearFit fit;
  {
    nb::gil_scoped_release release;
    fit = planes.linearised(points_xyz.data(), sigmas.data(), points_xyz.shape(0), pose.data(),
                            rules);
  }
  std::vector<double> hessian(fit.hessian.begin(), fit.hessian.end());
  std::vector<double> feigned(fit.feigned.begin(), fit.feigned.end());
  std::vector<double> gradient(fit.gradient.begin(), fit.gradient.end());
  return nb::make_tuple(given<Real>(std::move(hessian), {6, 6}),
                        given<Real>(std::move(feigned), {6, 6}),
                        given<Real>(std::move(gradient), {6}), fit.inliers, fit.overlap,
                        fit.distance, fit.residual, fit.misfit);
}

// The plane round each point through its neighbours, whose numbers are a row each.
nb::tuple plane_fits(Points points_xyz, Rows<int64_t> near, std::size_t threads) {
  const std::size_t count = near.shape(0), neighbours = near.shape(1);
  const auto points = static_cast<int64_t>(points_xyz.shape(0));
  require(neighbours >= 1 && neighbours <= 1000, "number of neighbours");
  for (std::size_t n = 0; n < count * neighbours; ++n) {
    require(near.data()[n] >= 0 && near.data()[n] < points, "neighbours that are points");
  }
  std::vector<double> normals(3 * count), variances(3 * count);
  {
    nb::gil_scoped_release release;
    parallel_for(count, threads, kPlanesPerThread, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) {
        const PlaneFit fit = plane_fit(points_xyz.data(), near.data() + n * neighbours, neighbours);
        std::copy(fit.normal.begin(), fit.normal.end(), &normals[3 * n]);
        std::copy(fit.variances.begin(), fit.variances.end(), &variances[3 * n]);
      }
    });
  }
  return nb::make_tuple(given<Real>(std::move(normals), {count, 3}),
                        given<Real>(std::move(variances), {count, 3}));
}

template <typename T>
using Corners = nb::ndarray<const T, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Flags = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// Per voxel the sums of weight, weighted point, weighted normal, and a one.
nb::tuple surface_sums(Corners<double> points_xyz, Corners<float> normals_xyz, Values32 weights,
                       Keys keys) {
  const std::size_t count = points_xyz.shape(0), columns = 8;
  require(normals_xyz.shape(0) == count && weights.shape(0) == count && keys.shape(0) == count,
          "one normal, weight and key a point");
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
  return nb::make_tuple(given<Whole>(std::move(found.keys), {voxels}),
                        given<Real>(std::move(totals), {voxels, columns}));
}

// Of rows of such sums the mean points and the unit normals, (0, 0, 1) where there is none.
nb::tuple surface_means(Rows<double> totals) {
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
  return nb::make_tuple(given<Real>(std::move(points), {count, 3}),
                        given<Real>(std::move(normals), {count, 3}));
}

nb::tuple merge_rays(Keys keys, Corners<float> origins_xyz, Corners<float> ends_xyz,
                     Flags on_object, Keys more_keys, Corners<float> more_origins_xyz,
                     Corners<float> more_ends_xyz, Flags more_on_object) {
  const auto checked = [](const Keys& k, const Corners<float>& o, const Corners<float>& e,
                          const Flags& f) {
    require(o.shape(0) == k.shape(0) && e.shape(0) == k.shape(0) && f.shape(0) == k.shape(0),
            "one origin, end and flag a key");
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
      given<Whole>(std::move(all), {count}), given<Single>(std::move(origins), {count, 3}),
      given<Single>(std::move(ends), {count, 3}), Given(flags, {count}, owner));
}

}  // namespace

NB_MODULE(_native, m) {
  using namespace nb::literals;
  m.doc() = "Native kernels of mapping.";
  nb::class_<PlaneMap>(m, "PlaneMap")
      .def(nb::new_(&make_planes), "points_xyz"_a, "normals_xyz"_a, "sigmas"_a, "slopes"_a,
           "unevenness"_a, "cell"_a)
      .def("linearised", &linearised, "points_xyz"_a, "sigmas"_a, "pose"_a, nb::kw_only(),
           "reach"_a, "tukey"_a, "correlation"_a, "least_spread"_a, "uneven"_a, "least_cut"_a,
           "floor"_a, "far"_a, "averted"_a, "standing"_a, "fewest"_a);
  m.def("plane_fits", &plane_fits, "points_xyz"_a, "near"_a, "threads"_a = 1);
  m.def("surface_sums", &surface_sums, "points_xyz"_a, "normals_xyz"_a, "weights"_a, "keys"_a);
  m.def("surface_means", &surface_means, "totals"_a);
  m.def("merge_rays", &merge_rays, "keys"_a, "origins_xyz"_a, "ends_xyz"_a, "on_object"_a,
        "more_keys"_a, "more_origins_xyz"_a, "more_ends_xyz"_a, "more_on_object"_a);
}
