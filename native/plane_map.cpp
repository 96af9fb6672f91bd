#include "plane_map.hpp"

#include <algorithm>
#include <cmath>

#include "median.hpp"

namespace circumspect {
namespace {

inline double square(double v) { return v * v; }

struct Match {
  double r, u, inverse_sigma, correlation, normal_variance, roughness;
  std::array<double, 3> p, facing;
};

// Whether a camera sees a plane's front, or its back at a grazing angle.
inline bool in_view(const Plane& plane, const std::array<double, 3>& camera,
                    double max_backface_cosine) {
  const double x = plane.x - camera[0], y = plane.y - camera[1], z = plane.z - camera[2];
  const double along = x * plane.nx + y * plane.ny + z * plane.nz;
  return along < 0.0 || square(along) < square(max_backface_cosine) * (x * x + y * y + z * z);
}

// Adds what noise of the normal, of variance v, contributes to the Hessian: v A (I - n nᵀ) Aᵀ with
// A = ([p]×, I) and J = A n. Only the lower triangle.
void add_spurious(double factor, const Match& m, PointToPlaneProblem& problem) {
  if (factor <= 0.0) return;
  const auto& [px, py, pz] = m.p;
  const auto& [nx, ny, nz] = m.facing;
  const double J[6] = {py * nz - pz * ny, pz * nx - px * nz, px * ny - py * nx, nx, ny, nz};
  const double p2 = px * px + py * py + pz * pz;
  const double AAt[6][6] = {{p2 - px * px, 0, 0, 0, 0, 0},
                            {-py * px, p2 - py * py, 0, 0, 0, 0},
                            {-pz * px, -pz * py, p2 - pz * pz, 0, 0, 0},
                            {0, pz, -py, 1, 0, 0},
                            {-pz, 0, px, 0, 1, 0},
                            {py, -px, 0, 0, 0, 1}};
  for (std::size_t a = 0; a < 6; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      problem.spurious[6 * a + b] += factor * (AAt[a][b] - J[a] * J[b]);
    }
  }
}

inline double tukey(double u, double cutoff) {
  return square(std::max(0.0, 1.0 - square(u / cutoff)));
}

// Adds up robustly weighted squares; `noise` is the noise scale of the residuals. The sensor's
// noise determines the inliers, all noise the weights.
void accumulate(const std::vector<Match>& matches, double noise, const FitSettings& settings,
                PointToPlaneProblem& problem) {
  const double cutoff = settings.tukey_cutoff * std::max(1.0, noise);
  double total = 0.0, r2 = 0.0, u2 = 0.0;
  for (const Match& m : matches) {
    const double inlier = tukey(m.u, cutoff);
    if (inlier <= 0.0) continue;
    problem.inliers += 1;
    total += inlier, r2 += inlier * m.r * m.r, u2 += inlier * m.u * m.u;
    // Both in units of the sensor's own variance.
    const double variance =
        noise * noise + settings.roughness_factor * m.roughness * square(m.inverse_sigma);
    const double w =
        tukey(m.u, settings.tukey_cutoff * std::max(settings.min_cutoff, std::sqrt(variance)));
    if (w <= 0.0) continue;
    const double weight = w / (settings.correlation_factor * m.correlation * variance);
    const auto& [px, py, pz] = m.p;
    const auto& [nx, ny, nz] = m.facing;
    const double s = m.inverse_sigma;
    const double J[6] = {s * (py * nz - pz * ny),
                         s * (pz * nx - px * nz),
                         s * (px * ny - py * nx),
                         s * nx,
                         s * ny,
                         s * nz};
    for (int a = 0; a < 6; ++a) {
      const double weighted = weight * J[a];
      for (int b = 0; b <= a; ++b) problem.hessian[std::size_t(6 * a + b)] += weighted * J[b];
      problem.gradient[std::size_t(a)] += weighted * m.u;
    }
    add_spurious(weight * s * s * m.normal_variance, m, problem);
  }
  for (std::size_t a = 0; a < 6; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      problem.hessian[6 * b + a] = problem.hessian[6 * a + b];
      problem.spurious[6 * b + a] = problem.spurious[6 * a + b];
    }
  }
  total = std::max(total, 1e-12);
  problem.residual = std::sqrt(r2 / total), problem.normalised_residual = std::sqrt(u2 / total);
}

}  // namespace

PlaneMap::PlaneMap(const double* points_xyz, const double* normals_xyz, const double* sigmas,
                   const double* normal_variances, const double* roughness, std::size_t count,
                   double cell)
    : cell_(cell), cells_(points_xyz, count, cell), planes_(count) {
  for (std::size_t place = 0; place < count; ++place) {
    const auto n = std::size_t(cells_.order()[place]);
    const double *p = points_xyz + 3 * n, *normal = normals_xyz + 3 * n;
    planes_[place] = Plane{p[0],
                           p[1],
                           p[2],
                           normal[0],
                           normal[1],
                           normal[2],
                           square(sigmas[n]),
                           normal_variances[n],
                           roughness[n]};
  }
}

const Plane* PlaneMap::nearest(double x, double y, double z, const std::array<double, 3>& camera,
                               double max_backface_cosine, double& within2) const {
  if (!(std::fabs(x) < kFarthest && std::fabs(y) < kFarthest && std::fabs(z) < kFarthest)) {
    return nullptr;
  }
  const double at[3] = {cells_.in_cells(x), cells_.in_cells(y), cells_.in_cells(z)};
  int64_t own[3];
  for (int a = 0; a < 3; ++a) own[a] = int64_t(std::floor(at[a]));
  const Plane* best = nullptr;
  const auto look = [&](int64_t i, int64_t j, int64_t k) {
    const CellTable::Slot* slot = cells_.find(own[0] + i, own[1] + j, own[2] + k);
    if (slot == nullptr) return;
    for (int32_t n = slot->begin; n < slot->end; ++n) {
      const Plane& plane = planes_[std::size_t(n)];
      const double d2 = square(plane.x - x) + square(plane.y - y) + square(plane.z - z);
      if (d2 < within2 && in_view(plane, camera, max_backface_cosine)) {
        within2 = d2, best = &plane;
      }
    }
  };
  look(0, 0, 0);
  // How far the cells i to one side are along an axis; rounding is allowed for.
  const auto apart2 = [&](int a, int64_t i) {
    const double inside = at[a] - double(own[a]);
    const double gap = i == 0 ? 0.0 : i > 0 ? double(i) - inside : inside - double(i + 1);
    return square(gap * cell_ * (1.0 - 1e-9));
  };
  const int64_t most = int64_t(std::ceil(cells_.in_cells(std::sqrt(within2))));
  for (int64_t i = -most; i <= most; ++i) {
    const double di = apart2(0, i);
    if (di >= within2) continue;
    for (int64_t j = -most; j <= most; ++j) {
      const double dj = di + apart2(1, j);
      if (dj >= within2) continue;
      for (int64_t k = -most; k <= most; ++k) {
        if ((i | j | k) != 0 && dj + apart2(2, k) < within2) look(i, j, k);
      }
    }
  }
  return best;
}

int64_t PlaneMap::nearest_row(double x, double y, double z, const std::array<double, 3>& camera,
                              double max_distance, double max_backface_cosine) const {
  double within2 = square(max_distance);
  const Plane* plane = nearest(x, y, z, camera, max_backface_cosine, within2);
  return plane == nullptr ? -1 : int64_t(cells_.order()[std::size_t(plane - planes_.data())]);
}

PointToPlaneProblem PlaneMap::linearised(const double* points_xyz, const double* sigmas,
                                         const double* correlations, std::size_t count,
                                         const double* T, const FitSettings& settings) const {
  PointToPlaneProblem problem;
  problem.distance = settings.max_plane_distance;
  std::vector<Match> matches;
  std::vector<double> sizes;
  matches.reserve(count), sizes.reserve(count);
  const std::array<double, 3> camera{T[3], T[7], T[11]};
  int64_t off_floor = 0, off_floor_matched = 0;
  double off_floor_sum = 0.0, sum = 0.0;
  for (std::size_t n = 0; n < count; ++n) {
    const double px = points_xyz[3 * n], py = points_xyz[3 * n + 1], pz = points_xyz[3 * n + 2];
    const double x = T[0] * px + T[1] * py + T[2] * pz + T[3];
    const double y = T[4] * px + T[5] * py + T[6] * pz + T[7];
    const double z = T[8] * px + T[9] * py + T[10] * pz + T[11];
    double within2 = square(settings.max_distance);
    const Plane* plane = nearest(x, y, z, camera, settings.max_backface_cosine, within2);
    double away = settings.max_plane_distance;
    if (plane != nullptr) {
      const double nx = plane->nx, ny = plane->ny, nz = plane->nz;
      const double r = (x - plane->x) * nx + (y - plane->y) * ny + (z - plane->z) * nz;
      const double s = 1.0 / std::sqrt(square(sigmas[n]) + plane->variance);
      away = std::min(std::fabs(r), settings.max_plane_distance);
      // The normal in the optical frame.
      matches.push_back({r,
                         r * s,
                         s,
                         correlations[n],
                         plane->normal_variance,
                         plane->roughness,
                         {px, py, pz},
                         {T[0] * nx + T[4] * ny + T[8] * nz, T[1] * nx + T[5] * ny + T[9] * nz,
                          T[2] * nx + T[6] * ny + T[10] * nz}});
      sizes.push_back(std::fabs(r * s));
    }
    sum += away;
    if (std::fabs(z) > settings.max_floor_height) {
      off_floor += 1, off_floor_matched += plane != nullptr, off_floor_sum += away;
    }
  }
  if (int64_t(matches.size()) < std::max<int64_t>(settings.min_correspondences, 1)) {
    return problem;
  }
  const bool enough = off_floor >= std::max<int64_t>(settings.min_points_off_floor, 1);
  problem.overlap = enough ? double(off_floor_matched) / double(off_floor)
                           : double(matches.size()) / double(count);
  problem.distance = enough ? off_floor_sum / double(off_floor) : sum / double(count);
  accumulate(matches, std::max(settings.min_noise_scale, 1.4826 * median(sizes)), settings,
             problem);
  return problem;
}

}  // namespace circumspect
