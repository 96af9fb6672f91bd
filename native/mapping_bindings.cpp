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
#include "parallel.hpp"
#include "plane_fits.hpp"
#include "plane_map.hpp"

namespace nb = nanobind;
using namespace circumspect;

namespace {

using Points = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Values = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Pose = nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu>;
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
}
