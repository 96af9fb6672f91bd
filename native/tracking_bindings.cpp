// Python's view of the kernels of tracking. Sizes are checked here, so that no argument can make a
// kernel read or write outside its arrays.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

#include "given.hpp"
#include "se3.hpp"
#include "skyline.hpp"
#include "smoother_window.hpp"

namespace nb = nanobind;
using namespace circumspect;

namespace {

template <nb::ssize_t... Shape>
using Array = nb::ndarray<const double, nb::shape<Shape...>, nb::c_contig, nb::device::cpu>;
using Stack = Array<-1, 4, 4>;
using Real = nb::ndarray<nb::numpy, double>;

constexpr std::size_t kMaxPoses = 1000;

void require(bool fulfilled, const char* message) {
  if (!fulfilled) throw std::invalid_argument(message);
}

nb::tuple window_linearised(Stack poses, Array<2> scale, Array<4, 4> prior_pose,
                            Array<2> prior_scale, Array<8, 8> prior_information, Stack motions,
                            Array<-1, 6, 2> by_scale, Array<-1, 6, 6> motion_information,
                            Stack measured, Array<-1, 6, 6> measured_information, Stack mounts,
                            Array<-1, 3, 3> level_information, double kernel, std::size_t count) {
  const std::size_t n = poses.shape(0);
  require(n >= 1 && n <= kMaxPoses, "1 to 1000 poses");
  require(motions.shape(0) == n - 1 && by_scale.shape(0) == n - 1 &&
              motion_information.shape(0) == n - 1,
          "one motion between consecutive poses");
  require(measured.shape(0) == n && measured_information.shape(0) == n && mounts.shape(0) == n &&
              level_information.shape(0) == n,
          "one measured pose, mount and information of each per pose");
  require(kernel > 0.0, "kernel");
  require(count <= n, "count");
  const SmootherWindow window{n,
                              poses.data(),
                              scale.data(),
                              prior_pose.data(),
                              prior_scale.data(),
                              prior_information.data(),
                              motions.data(),
                              by_scale.data(),
                              motion_information.data(),
                              measured.data(),
                              measured_information.data(),
                              mounts.data(),
                              level_information.data()};
  NormalEquations equations(0);
  {
    nb::gil_scoped_release release;
    equations = linearised(window, kernel, count);
  }
  const std::size_t size = equations.size;
  return nb::make_tuple(given<Real>(std::move(equations.hessian), {size, size}),
                        given<Real>(std::move(equations.gradient), {size}));
}

// H⁻¹ g, and the last `count` rows and columns of H⁻¹.
nb::tuple solved(Array<-1, -1> hessian, Array<-1> gradient, std::size_t count) {
  const std::size_t size = gradient.shape(0);
  require(hessian.shape(0) == size && hessian.shape(1) == size, "a row and column per variable");
  require(count <= size, "count");
  std::vector<double> solution, covariance;
  {
    nb::gil_scoped_release release;
    const Skyline factorised(hessian.data(), size);
    require(!factorised.is_singular(), "a Hessian that is not singular");
    solution = factorised.solved(gradient.data());
    covariance = factorised.inverse_end(count);
  }
  return nb::make_tuple(given<Real>(std::move(solution), {size}),
                        given<Real>(std::move(covariance), {count, count}));
}

// Poses after right perturbations.
Real moved(Stack poses, Array<-1, 6> changes) {
  const std::size_t count = poses.shape(0);
  require(changes.shape(0) == count, "one change per pose");
  std::vector<double> result(16 * count);
  {
    nb::gil_scoped_release release;
    for (std::size_t k = 0; k < count; ++k) {
      Vector<6> xi;
      std::copy(changes.data() + 6 * k, changes.data() + 6 * (k + 1), xi.begin());
      (Transform::from_rows(poses.data() + 16 * k) * exp(xi)).to_rows(&result[16 * k]);
    }
  }
  return given<Real>(std::move(result), {count, 4, 4});
}

}  // namespace

NB_MODULE(_native, m) {
  using namespace nb::literals;
  m.doc() = "Native kernels of tracking.";
  m.def("linearised", &window_linearised, "poses"_a, "scale"_a, "prior_pose"_a, "prior_scale"_a,
        "prior_information"_a, "motions"_a, "by_scale"_a, "motion_information"_a, "measured"_a,
        "measured_information"_a, "mounts"_a, "level_information"_a, "kernel"_a, "count"_a);
  m.def("solved", &solved, "hessian"_a, "gradient"_a, "count"_a);
  m.def("moved", &moved, "poses"_a, "changes"_a);
}
