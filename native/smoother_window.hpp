// The normal equations of the fixed-lag smoother's window; see smoother_window.py.
#pragma once

#include <cstddef>
#include <vector>

namespace circumspect {

// Row-major arrays of a window with n poses. Transforms are 4 x 4.
struct SmootherWindow {
  std::size_t poses;                                           // n
  const double *T_map_camera, *scale;                          // n poses; 2
  const double *prior_pose, *prior_scale, *prior_information;  // of the first pose; 2; 8 x 8
  const double *motions, *by_scale, *motion_information;       // n - 1 each; 6 x 2; 6 x 6
  const double *measured, *measured_information;               // n each; 6 x 6
  const double *mounts, *level_information;                    // n each; 3 x 3
};

// The Hessian and the gradient of half the cost. The variables are the right perturbations of the
// poses, 6 each, and the 2 scales.
struct NormalEquations {
  explicit NormalEquations(std::size_t poses)
      : size(6 * poses + 2), hessian(size * size), gradient(size) {}

  std::size_t size;
  std::vector<double> hessian, gradient;
};

// The prior and the factors of the first `count` poses and of the motions that start there. Motions
// and measured poses have Cauchy's kernel with parameter `kernel`. Factors with zero information
// are skipped. The variables are the poses that these factors depend on, and the scale.
NormalEquations linearised(const SmootherWindow& window, double kernel, std::size_t count);

}  // namespace circumspect
