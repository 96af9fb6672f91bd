#include "cylinder.hpp"

#include <algorithm>

#include "multiversion.hpp"

namespace circumspect {
namespace {

constexpr double kPi = 3.14159265358979323846;

// The direction after `step` of `steps` parts of a turn plus an offset below a full turn [rad].
Direction direction(int32_t step, int32_t steps, double offset) {
  const int64_t quarters = int64_t(step) * 4;
  const int64_t quarter = quarters / steps, rest = quarters % steps;
  const double angle = 0.5 * kPi * double(rest) / double(steps) + offset;
  Direction d{std::cos(angle), std::sin(angle)};
  if (offset == 0.0 && rest == 0) d = {1.0, 0.0};
  if (offset == 0.0 && 2 * rest == steps) d = {std::sqrt(0.5), std::sqrt(0.5)};
  for (int64_t turn = 0; turn < quarter % 4; ++turn) d = {-d.y, d.x};
  return d;
}

// atan(q) for q in [0, 1], within 6e-9 (minimax in q²).
inline double arc_tangent(double q) {
  const double s = q * q;
  double p = 0.00245668649199032;
  p = p * s - 0.014401199097485507;
  p = p * s + 0.03978095129097207;
  p = p * s - 0.07234832641096438;
  p = p * s + 0.10498933313878298;
  p = p * s - 0.14161225465816416;
  p = p * s + 0.19985906190551234;
  p = p * s - 0.3333259698835559;
  p = p * s + 0.9999998863750156;
  return p * q;
}
constexpr double kArcTangentError = 1e-8;

struct Scales {
  double x, y, z, radius, half_height;
  double per_radius, per_angle, per_height;    // cells per metre or radian
  double offset, sectors, near_boundary;       // in cells
  double last_radius, last_sector, last_height;
};

// Fills block.i, j, k; j is right only away from half-planes. Returns in block.x, block.y the
// point about the axis and in `nearest` the half-plane it is close to, or -1.
CIRCUMSPECT_MULTIVERSION
int locate_roughly(const Scales& s, Block& block, int32_t* __restrict nearest, int count) {
  int close_ones = 0;
  for (int n = 0; n < count; ++n) {
    const double x = block.x[n] - s.x, y = block.y[n] - s.y, z = block.z[n] - s.z;
    const double r = std::sqrt(x * x + y * y);
    const bool inside = (r <= s.radius) & (std::fabs(z) <= s.half_height);

    const double i = r * s.per_radius;
    const double k_up = (z + s.half_height) * s.per_height;
    const double k = k_up > 0.0 ? k_up : 0.0;

    const double ax = std::fabs(x), ay = std::fabs(y);
    const double large = ax > ay ? ax : ay, small = ax > ay ? ay : ax;
    const double q = small / (large > 1e-300 ? large : 1e-300);
    const double octant = arc_tangent(q);
    const double quadrant = ay > ax ? 0.5 * kPi - octant : octant;
    const double half = x < 0.0 ? kPi - quadrant : quadrant;
    const double angle = y < 0.0 ? 2.0 * kPi - half : half;
    const double turned = angle * s.per_angle - s.offset;
    const double t = turned < 0.0 ? turned + s.sectors : turned;

    // Comparisons are written so that NaN falls to the last cell and conversion is defined.
    const double t_safe = t < s.sectors ? t : s.sectors;
    const int32_t boundary = int32_t(t_safe + 0.5);
    const bool close = std::fabs(t_safe - double(boundary)) <= s.near_boundary;
    const int32_t sector = int32_t(t < s.last_sector ? t : s.last_sector);

    block.x[n] = x;
    block.y[n] = y;
    block.i[n] = inside ? int32_t(i < s.last_radius ? i : s.last_radius) : -1;
    block.j[n] = inside ? sector : -1;
    block.k[n] = inside ? int32_t(k < s.last_height ? k : s.last_height) : -1;
    const bool doubtful = close & inside;
    nearest[n] = doubtful ? boundary : -1;
    close_ones += doubtful;
  }
  return close_ones;
}

}  // namespace

Cylinder::Cylinder(Shape shape, double radius, double half_height, double x, double y, double z,
                   double azimuth_offset)
    : shape(shape), radius(radius), half_height(half_height), x(x), y(y), z(z),
      azimuth_offset(azimuth_offset) {
  sectors.reserve(std::size_t(shape.j) + 1);
  for (int32_t j = 0; j < shape.j; ++j) sectors.push_back(direction(j, shape.j, azimuth_offset));
  sectors.push_back(sectors.front());
}

void Cylinder::locate(Block& block, int count) const {
  Scales s;
  s.x = x, s.y = y, s.z = z, s.radius = radius, s.half_height = half_height;
  s.per_radius = shape.i / radius;
  s.per_angle = shape.j / (2.0 * kPi);
  s.per_height = shape.k / (2.0 * half_height);
  s.offset = azimuth_offset * s.per_angle;
  s.sectors = shape.j;
  s.near_boundary = kArcTangentError * s.per_angle + 1e-12 * shape.j;
  s.last_radius = shape.i - 1, s.last_sector = shape.j - 1, s.last_height = shape.k - 1;

  alignas(64) int32_t nearest[kBlock];
  if (locate_roughly(s, block, nearest, count) == 0) return;
  for (int n = 0; n < count; ++n) {
    if (nearest[n] >= 0) block.j[n] = sector_beside(nearest[n], block.x[n], block.y[n]);
  }
}

}  // namespace circumspect
