// Python's view of the kernels of mapping. Sizes are checked here, so that no argument can make a
// kernel read or write outside its arrays.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cmath>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "groups.hpp"
#include "plane_map.hpp"

namespace nb = nanobind;
using namespace circumspect;

namespace {

using Points = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Values = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Pose = nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu>;
using Keys = nb::ndarray<const int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Whole = nb::ndarray<nb::numpy, int64_t, nb::ndim<1>>;
using Real = nb::ndarray<nb::numpy, double>;
template <typename T>
using Rows = nb::ndarray<const T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

void require(bool fulfilled, const char* message) {
  if (!fulfilled) throw std::invalid_argument(message);
}

// Hands a vector over to NumPy without copying.
template <typename Array, typename T>
Array given(std::vector<T>&& values, std::initializer_list<std::size_t> shape) {
  auto* kept = new std::vector<T>(std::move(values));
  nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return Array(kept->data(), shape, owner);
}

PlaneMap* make_planes(Points points_xyz, Points normals_xyz, Values sigmas, double cell) {
  const std::size_t count = points_xyz.shape(0);
  require(normals_xyz.shape(0) == count && sigmas.shape(0) == count, "one normal and sigma a point");
  require(count < (std::size_t(1) << 30), "number of points");
  require(cell >= 1e-3 && cell <= 1e3, "cell");
  for (std::size_t n = 0; n < 3 * count; ++n) {
    require(std::fabs(points_xyz.data()[n]) < kFarthest, "points that are finite and within 1000 km");
  }
  nb::gil_scoped_release release;
  return new PlaneMap(points_xyz.data(), normals_xyz.data(), sigmas.data(), count, cell);
}

nb::tuple linearised(const PlaneMap& planes, Points points_xyz, Values sigmas, Pose pose,
                     double reach, double tukey, double correlation, double least_spread,
                     double floor, double far, int64_t standing, int64_t fewest) {
  require(sigmas.shape(0) == points_xyz.shape(0), "one sigma a point");
  require(reach > 0.0 && reach <= 10.0, "reach");
  const FitRules rules{reach, tukey, correlation, least_spread, floor, far, standing, fewest};
  LinearFit fit;
  {
    nb::gil_scoped_release release;
    fit = planes.linearised(points_xyz.data(), sigmas.data(), points_xyz.shape(0), pose.data(),
                            rules);
  }
  std::vector<double> hessian(fit.hessian.begin(), fit.hessian.end());
  std::vector<double> gradient(fit.gradient.begin(), fit.gradient.end());
  return nb::make_tuple(given<Real>(std::move(hessian), {6, 6}),
                        given<Real>(std::move(gradient), {6}), fit.inliers, fit.overlap,
                        fit.distance, fit.residual, fit.misfit);
}

nb::tuple groups(Keys keys) {
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

template <typename T>
nb::tuple row_sums(Keys keys, Rows<T> values) {
  const std::size_t columns = values.shape(1);
  require(values.shape(0) == keys.shape(0), "one row a key");
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
                        given<Real>(std::move(totals), {count, columns}));
}

nb::tuple table_sum(Keys one_keys, Rows<double> one, Keys other_keys, Rows<double> other) {
  const std::size_t columns = one.shape(1);
  require(one.shape(0) == one_keys.shape(0) && other.shape(0) == other_keys.shape(0) &&
              other.shape(1) == columns,
          "one row a key and as many columns");
  MergedTable sum;
  {
    nb::gil_scoped_release release;
    sum = merged({one_keys.data(), one.data(), one.shape(0)},
                 {other_keys.data(), other.data(), other.shape(0)}, columns);
  }
  const std::size_t count = sum.keys.size();
  return nb::make_tuple(given<Whole>(std::move(sum.keys), {count}),
                        given<Real>(std::move(sum.totals), {count, columns}));
}

}  // namespace

NB_MODULE(_native, m) {
  using namespace nb::literals;
  m.doc() = "Native kernels of mapping.";
  nb::class_<PlaneMap>(m, "PlaneMap")
      .def(nb::new_(&make_planes), "points_xyz"_a, "normals_xyz"_a, "sigmas"_a, "cell"_a)
      .def("linearised", &linearised, "points_xyz"_a, "sigmas"_a, "pose"_a, nb::kw_only(),
           "reach"_a, "tukey"_a, "correlation"_a, "least_spread"_a, "floor"_a, "far"_a,
           "standing"_a, "fewest"_a);
  m.def("groups", &groups, "keys"_a);
  m.def("row_sums", &row_sums<double>, "keys"_a, "values"_a);
  m.def("row_sums", &row_sums<float>, "keys"_a, "values"_a);
  m.def("table_sum", &table_sum, "one_keys"_a, "one"_a, "other_keys"_a, "other"_a);
}
