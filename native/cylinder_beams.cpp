#include "cylinder_beams.hpp"

#include <cmath>

#include "azimuth.hpp"
#include "multiversion.hpp"

namespace circumspect {
namespace {

// Along a beam, r² = nearest² + speed² (t - turn)², in cells.
struct CylinderBeams : Beams {
  alignas(64) double turn[kBeams], nearest2[kBeams], speed2[kBeams];
  alignas(64) double sweep[kBeams];  // o x d seen from above: counter-clockwise where positive
  alignas(64) float start_x[kBeams], start_y[kBeams], end_x[kBeams], end_y[kBeams];  // in radii
  alignas(64) int32_t first_ring[kBeams], last_ring[kBeams], turn_ring[kBeams];
  alignas(64) int32_t first_layer[kBeams], last_layer[kBeams];
  alignas(64) int32_t first_sector[kBeams], last_sector[kBeams];
};

struct Scales {
  double radius2, rings2, most_ring2, per_radius;
  double half_height, per_half_height, half_layers, last_layer;
};

// Clips beams to the cylinder: between the roots of the quadratic and between top and bottom.
CIRCUMSPECT_MULTIVERSION
void clip_beams(const Scales& s, CylinderBeams& b, int count) {
  for (int n = 0; n < count; ++n) {
    const double ox = b.ox[n], oy = b.oy[n], dx = b.dx[n], dy = b.dy[n];
    const double a = dx * dx + dy * dy, sweep = ox * dy - oy * dx;
    const double level = a > 0.0 ? 1.0 : 0.0, divisor = a > 0.0 ? a : 1.0;
    const double turn = -(ox * dx + oy * dy) / divisor * level;
    const double passing = sweep / divisor * sweep, standing = ox * ox + oy * oy;
    const double nearest2 = a > 0.0 ? passing : standing;
    const double inside2 = s.radius2 - nearest2;
    const double half_chord = std::sqrt((inside2 > 0.0 ? inside2 : 0.0) / divisor);
    const double reach = a > 0.0 ? half_chord : 1e300;
    double start = turn - reach, end = turn + reach;
    start = start > 0.0 ? start : 0.0;
    end = end < 1.0 ? end : 1.0;
    start = inside2 >= 0.0 ? start : 2.0;
    clip(b.oz[n], b.dz[n], s.half_height, start, end);
    b.start[n] = start, b.end[n] = end;
    b.turn[n] = turn, b.sweep[n] = sweep;
    b.nearest2[n] = nearest2 * s.rings2, b.speed2[n] = a * s.rings2;
  }
}

// The ring, to be rounded down. Limited before the root: the last ring includes its boundary.
inline double ring_at(double nearest2, double speed2, double since_turn, double most2) {
  const double r2 = nearest2 + speed2 * since_turn * since_turn;
  return std::sqrt(r2 < most2 ? r2 : most2);
}

inline double most_ring2(int32_t rings) { return (rings - 1e-9) * (rings - 1e-9); }

inline double layer_at(const Scales& s, double z) {
  return cell_at(cells_from_side(z, s.per_half_height, s.half_layers), s.last_layer);
}

// Rings and layers where beams enter and leave; where that is, for the sectors.
CIRCUMSPECT_MULTIVERSION
void find_ends(const Scales& s, CylinderBeams& b, int count) {
  for (int n = 0; n < count; ++n) {
    const double to_start = b.start[n] - b.turn[n], to_end = b.end[n] - b.turn[n];
    b.first_ring[n] = int32_t(ring_at(b.nearest2[n], b.speed2[n], to_start, s.most_ring2));
    b.last_ring[n] = int32_t(ring_at(b.nearest2[n], b.speed2[n], to_end, s.most_ring2));
    b.turn_ring[n] = int32_t(ring_at(b.nearest2[n], b.speed2[n], 0.0, s.most_ring2));
  }
  for (int n = 0; n < count; ++n) {
    const double low = b.oz[n] + b.start[n] * b.dz[n], high = b.oz[n] + b.end[n] * b.dz[n];
    b.first_layer[n] = int32_t(layer_at(s, low));
    b.last_layer[n] = int32_t(layer_at(s, high));
  }
  for (int n = 0; n < count; ++n) {
    b.start_x[n] = float((b.ox[n] + b.start[n] * b.dx[n]) * s.per_radius);
    b.start_y[n] = float((b.oy[n] + b.start[n] * b.dy[n]) * s.per_radius);
    b.end_x[n] = float((b.ox[n] + b.end[n] * b.dx[n]) * s.per_radius);
    b.end_y[n] = float((b.oy[n] + b.end[n] * b.dy[n]) * s.per_radius);
  }
}

// Sectors in single precision, -1 where too close to a half-plane or to the axis to decide.
CIRCUMSPECT_MULTIVERSION
void find_sectors(float per_angle, float offset, float sectors, const float* __restrict xs,
                  const float* __restrict ys, int32_t* __restrict found, int count) {
  const float doubt = kDoubt * sectors;
  for (int n = 0; n < count; ++n) {
    const float x = xs[n], y = ys[n];
    const float j = sector_at(x, y, per_angle, offset, sectors);
    const int32_t sure = (from_boundary(j) > doubt) & (x * x + y * y > 1e-10f);
    found[n] = (int32_t(j) + 1) * sure - 1;
  }
}

// What the crossings of one beam share.
struct Course {
  double start, end, turn, nearest2, speed2, most_ring2;
};

// When a crossing counts: rounding must not lead out of the grid.
inline double within(double t, const Course& c) {
  const double after = t > c.start ? t : c.start;
  return after < c.end ? after : c.end;
}

// Where the beam crosses half-planes (hx, hy).
inline void cross_sectors(const CylinderBeams& b, int n, const Course c,
                          const double* __restrict hx, const double* __restrict hy,
                          Crossings& out) {
  const double ox = b.ox[n], oy = b.oy[n], dx = b.dx[n], dy = b.dy[n];
  double* __restrict ts = out.t.data();
  int32_t* __restrict rings = out.cell.data();
  const int32_t padded = Crossings::padded(out.sides);
  CIRCUMSPECT_NO_OVERLAP
  for (int32_t m = 0; m < padded; ++m) {
    const double t = within((hy[m] * ox - hx[m] * oy) / (hx[m] * dy - hy[m] * dx), c);
    ts[m] = t;
    rings[m] = int32_t(ring_at(c.nearest2, c.speed2, t - c.turn, c.most_ring2));
  }
}

// Where the beam crosses layers, first at height `first` [m] about the centre.
inline void cross_layers(const CylinderBeams& b, int n, const Course c, double first, double step,
                         Crossings& out) {
  const double per_dz = 1.0 / b.dz[n];
  const double t_first = (first - b.oz[n]) * per_dz, t_step = step * per_dz;
  double* __restrict ts = out.t.data() + out.first_layer;
  int32_t* __restrict rings = out.cell.data() + out.first_layer;
  const int32_t padded = Crossings::padded(out.layers);
  CIRCUMSPECT_NO_OVERLAP
  for (int32_t m = 0; m < padded; ++m) {
    const double t = within(t_first + double(m) * t_step, c);
    ts[m] = t;
    rings[m] = int32_t(ring_at(c.nearest2, c.speed2, t - c.turn, c.most_ring2));
  }
}

// Finds the crossings of layers; returns the step from one to the next.
inline int32_t walk_layers(const Cylinder& grid, const CylinderBeams& b, int n, const Course& c,
                           Crossings& out) {
  const double layer_height = 2.0 * grid.half_height / grid.shape.k;
  const int32_t layer = b.first_layer[n], rise = b.last_layer[n] - layer;
  const int32_t up = rise > 0 ? 1 : -1;
  out.layers = rise * up;
  const double side = (2.0 * (layer + (rise > 0)) / grid.shape.k - 1.0) * grid.half_height;
  cross_layers(b, n, c, side, up * layer_height, out);
  return up;
}

// Finds the crossings of half-planes; returns the step from one sector to the next.
inline int32_t walk_sectors(const Cylinder& grid, const CylinderBeams& b, int n, const Course& c,
                            Crossings& out) {
  const int32_t all = grid.shape.j, most = (all + 1) / 2, sector = b.first_sector[n];
  int32_t turned = b.last_sector[n] - sector;
  if (b.sweep[n] == 0.0) {
    // Through the axis: from one sector straight into the other.
    out.sides = turned != 0;
    out.t[0] = c.turn, out.cell[0] = 0;
    return turned;
  }
  const bool forward = b.sweep[n] > 0.0;
  turned = forward ? turned : -turned;
  turned += turned < 0 ? all : 0;
  // A beam turns by less than half round the axis; more means that rounding put an end that lies
  // on a half-plane behind it.
  const bool left = forward == (turned <= most);
  out.sides = turned <= most ? turned : all - turned;
  const std::size_t next = std::size_t(left ? sector + 1 : all - sector);
  const HalfPlanes& sides = left ? grid.forward : grid.backward;
  cross_sectors(b, n, c, sides.x.data() + next, sides.y.data() + next, out);
  return left ? 1 : -1;
}

// A column is all rings of one sector and layer. Columns are numbered twice round, so that no
// step has to close the circle.
CIRCUMSPECT_MULTIVERSION
void walk_beams(const Cylinder& grid, const CylinderBeams& b, int count, Crossings& crossings,
                Columns& columns) {
  const double most2 = most_ring2(grid.shape.i);
  const std::ptrdiff_t row = grid.shape.k;
  for (int n = 0; n < count; ++n) {
    if (!(b.start[n] <= b.end[n])) continue;
    const Course course{b.start[n], b.end[n], b.turn[n], b.nearest2[n], b.speed2[n], most2};
    const int32_t up = walk_layers(grid, b, n, course, crossings);
    const int32_t rows = walk_sectors(grid, b, n, course, crossings);
    const int32_t sector = b.first_sector[n] + (rows < 0 ? grid.shape.j : 0);
    const Walk walk{sector * row + b.first_layer[n],
                    rows * row,
                    up,
                    course.start,
                    course.end,
                    b.first_ring[n],
                    b.last_ring[n],
                    course.turn,
                    b.turn_ring[n]};
    columns.set(walk, crossings);
  }
}

// Beams that meet the axis have no azimuth there: theirs is that of their direction.
void correct_sectors(const Cylinder& grid, CylinderBeams& b, int count) {
  for (int n = 0; n < count; ++n) {
    if (!(b.start[n] <= b.end[n])) continue;
    const double dx = b.dx[n], dy = b.dy[n];
    if (b.sweep[n] == 0.0 && (dx != 0.0 || dy != 0.0)) {
      const double from = b.start[n] < b.turn[n] ? -1.0 : 1.0;
      const double to = b.end[n] > b.turn[n] ? 1.0 : -1.0;
      b.first_sector[n] = grid.sector_of(from * dx, from * dy);
      b.last_sector[n] = grid.sector_of(to * dx, to * dy);
      continue;
    }
    if (b.first_sector[n] < 0) {
      b.first_sector[n] = grid.sector_of(b.ox[n] + b.start[n] * dx, b.oy[n] + b.start[n] * dy);
    }
    if (b.last_sector[n] < 0) {
      b.last_sector[n] = grid.sector_of(b.ox[n] + b.end[n] * dx, b.oy[n] + b.end[n] * dy);
    }
  }
}

}  // namespace

struct CylinderTracer::Scratch {
  explicit Scratch(const Shape& shape) : crossings(std::size_t(shape.j), std::size_t(shape.k)) {}
  CylinderBeams beams;
  Crossings crossings;
};

CylinderTracer::CylinderTracer(const Cylinder& grid)
    : grid_(grid),
      columns_(2 * std::size_t(grid.shape.j) * std::size_t(grid.shape.k), grid.shape.i),
      scratch_(std::make_unique<Scratch>(grid.shape)) {}

CylinderTracer::~CylinderTracer() = default;

Beams& CylinderTracer::beams() { return scratch_->beams; }

void CylinderTracer::trace(int count) {
  CylinderBeams& b = scratch_->beams;
  const double per_angle = grid_.shape.j / (2.0 * kPi), rings = grid_.shape.i / grid_.radius;
  Scales s;
  s.radius2 = grid_.radius * grid_.radius;
  s.half_height = grid_.half_height;
  s.per_radius = 1.0 / grid_.radius;
  s.per_half_height = 1.0 / grid_.half_height, s.half_layers = 0.5 * grid_.shape.k;
  s.most_ring2 = most_ring2(grid_.shape.i), s.last_layer = grid_.shape.k - 1;
  s.rings2 = rings * rings;
  clip_beams(s, b, count);
  find_ends(s, b, count);
  const float offset = float(grid_.azimuth_offset * per_angle), sectors = float(grid_.shape.j);
  find_sectors(float(per_angle), offset, sectors, b.start_x, b.start_y, b.first_sector, count);
  find_sectors(float(per_angle), offset, sectors, b.end_x, b.end_y, b.last_sector, count);
  correct_sectors(grid_, b, count);
  walk_beams(grid_, b, count, scratch_->crossings, columns_);
}

bool CylinderTracer::passed(int32_t i, int32_t j, int32_t k) const {
  const std::size_t layers = std::size_t(grid_.shape.k), once = std::size_t(grid_.shape.j) * layers;
  const std::size_t column = std::size_t(j) * layers + std::size_t(k);
  return columns_.get(column, i) || columns_.get(column + once, i);
}

}  // namespace circumspect
