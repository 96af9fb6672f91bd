// Python's view of the kernels of registration. Sizes are checked here, so that no argument can
// make a kernel read or write outside its arrays.
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
using Vector = nb::ndarray<const double, nb::shape<3>, nb::c_contig, nb::device::cpu>;
using Whole = nb::ndarray<nb::numpy, int64_t, nb::ndim<1>>;
using Real = nb::ndarray<nb::numpy, double>;
template <typename T>
using Rows = nb::ndarray<const T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

constexpr std::size_t kPlanesPerThread = 500;  // fewer are fitted before a thread has started

void require(bool fulfilled, const char* message) {
  if (!fulfilled) throw std::invalid_argument(message);
}

PlaneMap* make_planes(Points points_xyz, Points normals_xyz, Values sigmas, Values normal_variances,
                      Values roughness, double cell) {
  const std::size_t count = points_xyz.shape(0);
  require(normals_xyz.shape(0) == count && sigmas.shape(0) == count &&
              normal_variances.shape(0) == count && roughness.shape(0) == count,
          "one normal, sigma, normal variance and roughness per point");
  require(count < (std::size_t(1) << 30), "number of points");
  require(cell >= 1e-3 && cell <= 1e3, "cell");
  for (std::size_t n = 0; n < 3 * count; ++n) {
    require(std::fabs(points_xyz.data()[n]) < kFarthest,
            "points that are finite and within 1000 km");
  }
  nb::gil_scoped_release release;
  return new PlaneMap(points_xyz.data(), normals_xyz.data(), sigmas.data(), normal_variances.data(),
                      roughness.data(), count, cell);
}

nb::tuple linearised(const PlaneMap& planes, Points points_xyz, Values sigmas, Values correlations,
                     Pose pose, double max_distance, double tukey_cutoff, double correlation_factor,
                     double min_noise_scale, double roughness_factor, double min_cutoff,
                     double max_floor_height, double max_plane_distance, double max_backface_cosine,
                     int64_t min_points_off_floor, int64_t min_correspondences) {
  require(sigmas.shape(0) == points_xyz.shape(0) && correlations.shape(0) == points_xyz.shape(0),
          "one sigma and correlation per point");
  require(max_distance > 0.0 && max_distance <= 10.0, "max_distance");
  const FitSettings settings{max_distance,         tukey_cutoff,       correlation_factor,
                             min_noise_scale,      roughness_factor,   min_cutoff,
                             max_floor_height,     max_plane_distance, max_backface_cosine,
                             min_points_off_floor, min_correspondences};
  PointToPlaneProblem problem;
  {
    nb::gil_scoped_release release;
    problem = planes.linearised(points_xyz.data(), sigmas.data(), correlations.data(),
                                points_xyz.shape(0), pose.data(), settings);
  }
  std::vector<double> hessian(problem.hessian.begin(), problem.hessian.end());
  std::vector<double> spurious(problem.spurious.begin(), problem.spurious.end());
  std::vector<double> gradient(problem.gradient.begin(), problem.gradient.end());
  return nb::make_tuple(given<Real>(std::move(hessian), {6, 6}),
                        given<Real>(std::move(spurious), {6, 6}),
                        given<Real>(std::move(gradient), {6}), problem.inliers, problem.overlap,
                        problem.distance, problem.residual, problem.normalised_residual);
}

// The row of the plane nearest to each point that a camera can see, or -1.
Whole nearest(const PlaneMap& planes, Points points_xyz, Vector camera_xyz, double max_distance,
              double max_backface_cosine) {
  require(max_distance > 0.0 && max_distance <= 10.0, "max_distance");
  const std::size_t count = points_xyz.shape(0);
  const std::array<double, 3> camera{camera_xyz.data()[0], camera_xyz.data()[1],
                                     camera_xyz.data()[2]};
  std::vector<int64_t> rows(count);
  {
    nb::gil_scoped_release release;
    for (std::size_t n = 0; n < count; ++n) {
      const double* p = points_xyz.data() + 3 * n;
      rows[n] = planes.nearest_row(p[0], p[1], p[2], camera, max_distance, max_backface_cosine);
    }
  }
  return given<Whole>(std::move(rows), {count});
}

// The plane through the neighbours of each point; a row holds their indices.
nb::tuple plane_fits(Points points_xyz, Rows<int64_t> neighbours, std::size_t threads) {
  const std::size_t count = neighbours.shape(0), per_point = neighbours.shape(1);
  const auto points = static_cast<int64_t>(points_xyz.shape(0));
  require(per_point >= 1 && per_point <= 1000, "number of neighbours");
  for (std::size_t n = 0; n < count * per_point; ++n) {
    require(neighbours.data()[n] >= 0 && neighbours.data()[n] < points,
            "neighbours that are points");
  }
  std::vector<double> normals(3 * count), variances(3 * count);
  {
    nb::gil_scoped_release release;
    parallel_for(count, threads, kPlanesPerThread, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) {
        const PlaneFit fit =
            plane_fit(points_xyz.data(), neighbours.data() + n * per_point, per_point);
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
  m.doc() = "Native kernels of registration.";
  nb::class_<PlaneMap>(m, "PlaneMap")
      .def(nb::new_(&make_planes), "points_xyz"_a, "normals_xyz"_a, "sigmas"_a,
           "normal_variances"_a, "roughness"_a, "cell"_a)
      .def("nearest", &nearest, "points_xyz"_a, "camera_xyz"_a, "max_distance"_a,
           "max_backface_cosine"_a)
      .def("linearised", &linearised, "points_xyz"_a, "sigmas"_a, "correlations"_a, "pose"_a,
           nb::kw_only(), "max_distance"_a, "tukey_cutoff"_a, "correlation_factor"_a,
           "min_noise_scale"_a, "roughness_factor"_a, "min_cutoff"_a, "max_floor_height"_a,
           "max_plane_distance"_a, "max_backface_cosine"_a, "min_points_off_floor"_a,
           "min_correspondences"_a);
  m.def("plane_fits", &plane_fits, "points_xyz"_a, "neighbours"_a, "threads"_a = 1);
}
