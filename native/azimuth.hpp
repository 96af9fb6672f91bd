// Angles about the axis, near enough to look up a sector; half-planes then decide exactly.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

namespace circumspect {

inline constexpr double kPi = 3.14159265358979323846;

// atan(q) for q in [0, 1]: minimax in q², as short as keeps few points in doubt (see `locate`).
template <typename Real>
inline Real arc_tangent(Real q) {
  const Real s = q * q;
  Real p = Real(-0.011718965301635024);
  p = p * s + Real(0.05264689641693929);
  p = p * s - Real(0.11642604185132964);
  p = p * s + Real(0.19354019087171523);
  p = p * s - Real(0.33262279634452757);
  p = p * s + Real(0.9999772175987809);
  return p * q;
}
inline constexpr double kArcTangentError = 1.7e-6;

// Within [0, most]; NaN too, so that conversion to a whole number is always defined.
template <typename Real>
inline Real clamped(Real value, Real most) {
  const Real up = value > Real(0) ? value : Real(0);
  return up < most ? up : most;
}

// The azimuth of a point about the axis [rad]: 0 … 2 pi.
template <typename Real>
inline Real azimuth_of(Real x, Real y) {
  const Real ax = std::fabs(x), ay = std::fabs(y);
  const Real large = ax > ay ? ax : ay, small = ax > ay ? ay : ax;
  constexpr Real kTiny = std::numeric_limits<Real>::min();
  const Real octant = arc_tangent(small / (large > kTiny ? large : kTiny));
  const Real quadrant = ay > ax ? Real(0.5 * kPi) - octant : octant;
  const Real half = x < Real(0) ? Real(kPi) - quadrant : quadrant;
  return y < Real(0) ? Real(2.0 * kPi) - half : half;
}

// An azimuth in sectors from the first: 0 … sectors.
template <typename Real>
inline Real sectors_from(Real azimuth, Real per_angle, Real offset, Real sectors) {
  const Real turned = azimuth * per_angle - offset;
  return clamped(turned + (turned < Real(0) ? sectors : Real(0)), sectors);
}

// The same of a point about the axis.
template <typename Real>
inline Real sector_at(Real x, Real y, Real per_angle, Real offset, Real sectors) {
  return sectors_from(azimuth_of(x, y), per_angle, offset, sectors);
}

// Distance of a place, in cells and not negative, to the nearest boundary.
inline float from_boundary(float at) { return std::fabs(at - float(int32_t(at + 0.5f))); }

// What single precision and the arc tangent may be wrong by, in parts of a whole axis.
inline constexpr float kDoubt = 1.5e-6f;

}  // namespace circumspect
