#include "cylinder.hpp"

#include "azimuth.hpp"
#include "multiversion.hpp"

namespace circumspect {
namespace {

struct Direction {
  double x, y;
};

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

// All lengths in radii and half heights, so that single precision has room.
struct Scales {
  double x, y, z, per_radius, per_half_height;
  float radii, per_angle, offset, sectors, layers;
  float doubt_radius, doubt_sector, doubt_height;  // cells from a boundary where rounding matters
};

struct Scaled {
  alignas(64) float x[kBlock], y[kBlock], z[kBlock];
};

CIRCUMSPECT_MULTIVERSION
void scale(const Scales& s, const Block& block, Scaled& scaled, int count) {
  for (int n = 0; n < count; ++n) scaled.x[n] = float((block.x[n] - s.x) * s.per_radius);
  for (int n = 0; n < count; ++n) scaled.y[n] = float((block.y[n] - s.y) * s.per_radius);
  for (int n = 0; n < count; ++n) scaled.z[n] = float((block.z[n] - s.z) * s.per_half_height);
}

// Cells in single precision. `doubtful` is 1 for points so close to a boundary that they have to
// be looked at again; returns whether there are any.
CIRCUMSPECT_MULTIVERSION
bool locate_roughly(const Scales& s, const Scaled& scaled, Block& block,
                    int32_t* __restrict doubtful, int count) {
  int32_t any = 0;
  for (int n = 0; n < count; ++n) {
    const float x = scaled.x[n], y = scaled.y[n], z = scaled.z[n];
    const float r = std::sqrt(x * x + y * y), height = std::fabs(z);
    const float i = clamped(r * s.radii, s.radii);
    const float j = sector_at(x, y, s.per_angle, s.offset, s.sectors);
    const float k = clamped((z + 1.0f) * 0.5f * s.layers, s.layers);

    const int32_t outside = (r > 1.00001f) | (height > 1.00001f);
    const int32_t sure = (from_boundary(i) > s.doubt_radius) & (from_boundary(j) > s.doubt_sector) &
                         (from_boundary(k) > s.doubt_height);
    block.i[n] = int32_t(i) | -outside;
    block.j[n] = int32_t(j) | -outside;
    block.k[n] = int32_t(k) | -outside;
    doubtful[n] = 1 & ~(outside | sure);
    any |= doubtful[n];
  }
  return any != 0;
}

}  // namespace

Cylinder::Cylinder(Shape shape, double radius, double half_height, double x, double y, double z,
                   double azimuth_offset)
    : shape(shape), radius(radius), half_height(half_height), x(x), y(y), z(z),
      azimuth_offset(azimuth_offset) {
  // Twice round and a little: walks over half-planes need not look where the turn ends.
  const int32_t listed = 2 * shape.j + 8;
  for (int32_t step = 0; step < listed; ++step) {
    const Direction d = direction(step % shape.j, shape.j, azimuth_offset);
    forward.x.push_back(d.x), forward.y.push_back(d.y);
  }
  for (int32_t step = 0; step < listed; ++step) {
    const std::size_t j = std::size_t((listed * shape.j - step) % shape.j);
    backward.x.push_back(forward.x[j]), backward.y.push_back(forward.y[j]);
  }
}

Cell Cylinder::cell_of(double x_about, double y_about, double z_about) const {
  const double r = std::sqrt(x_about * x_about + y_about * y_about);
  if (!(r <= radius && std::fabs(z_about) <= half_height)) return {-1, -1, -1};
  const double i = clamped(r * (shape.i / radius), double(shape.i - 1));
  const double k =
      clamped(cells_from_side(z_about, 1.0 / half_height, 0.5 * shape.k), double(shape.k - 1));
  return {int32_t(i), sector_of(x_about, y_about), int32_t(k)};
}

int32_t Cylinder::sector_of(double x_about, double y_about) const {
  const double per_angle = shape.j / (2.0 * kPi);
  const double j =
      sector_at(x_about, y_about, per_angle, azimuth_offset * per_angle, double(shape.j));
  const int32_t nearest = int32_t(j + 0.5);
  if (std::fabs(j - nearest) > 2.0 * kArcTangentError * per_angle) return int32_t(j);
  const double hx = forward.x[std::size_t(nearest)], hy = forward.y[std::size_t(nearest)];
  const bool behind = hx * y_about - hy * x_about < 0.0;
  return behind ? (nearest > 0 ? nearest : shape.j) - 1 : nearest % shape.j;
}

void Cylinder::locate(Block& block, int count) const {
  Scales s;
  s.x = x, s.y = y, s.z = z, s.per_radius = 1.0 / radius, s.per_half_height = 1.0 / half_height;
  s.radii = float(shape.i), s.sectors = float(shape.j), s.layers = float(shape.k);
  s.per_angle = float(shape.j / (2.0 * kPi));
  s.offset = float(azimuth_offset * (shape.j / (2.0 * kPi)));
  s.doubt_radius = kDoubt * s.radii;
  s.doubt_sector = kDoubt * s.sectors;
  s.doubt_height = kDoubt * s.layers;

  Scaled scaled;
  alignas(64) int32_t doubtful[kBlock];
  scale(s, block, scaled, count);
  if (!locate_roughly(s, scaled, block, doubtful, count)) return;
  for (int n = 0; n < count; ++n) {
    if (!doubtful[n]) continue;
    const Cell cell = cell_of(block.x[n] - x, block.y[n] - y, block.z[n] - z);
    block.i[n] = cell.i, block.j[n] = cell.j, block.k[n] = cell.k;
  }
}

}  // namespace circumspect
