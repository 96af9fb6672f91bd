#include "box_beams.hpp"

#include <cmath>

#include "multiversion.hpp"

namespace circumspect {
namespace {

// Into the axes of the cube, then clips to it.
CIRCUMSPECT_MULTIVERSION
void turn_and_clip(const Box& grid, Beams& b, int count) {
  const double cosine = grid.cosine, sine = grid.sine, half_width = grid.half_width;
  for (int n = 0; n < count; ++n) {
    const double ox = b.ox[n], oy = b.oy[n], dx = b.dx[n], dy = b.dy[n];
    b.ox[n] = cosine * ox + sine * oy;
    b.oy[n] = cosine * oy - sine * ox;
    b.dx[n] = cosine * dx + sine * dy;
    b.dy[n] = cosine * dy - sine * dx;
  }
  for (int n = 0; n < count; ++n) {
    double start = 0.0, end = 1.0;
    clip(b.ox[n], b.dx[n], half_width, start, end);
    clip(b.oy[n], b.dy[n], half_width, start, end);
    clip(b.oz[n], b.dz[n], half_width, start, end);
    b.start[n] = start, b.end[n] = end;
  }
}

// A beam along one axis of the cube, in cells.
struct Along {
  double at, per_t, end;  // at t = 0, change until t = 1, number of cells
  int32_t first, last;    // cells at start and end

  Along(double o, double d, double half_width, int32_t cells, double start, double end)
      : at(cells_from_side(o, 1.0 / half_width, 0.5 * cells)),
        per_t(d * (1.0 / half_width) * (0.5 * cells)), end(cells - 1e-9), first(cell(start)),
        last(cell(end)) {}

  int32_t cell(double t) const {
    const double there = at + t * per_t;
    const double up = there > 0.0 ? there : 0.0;
    return int32_t(up < end ? up : end);
  }
  int32_t step() const { return last > first ? 1 : -1; }
  int32_t crossings() const { return last > first ? last - first : first - last; }
};

// Where the beam crosses the boundaries of cells along `across`.
inline void cross(const Along& across, const Along& along, double start, double end,
                  double* __restrict ts, int32_t* __restrict cells) {
  const double first = across.last > across.first ? across.first + 1 : across.first;
  const double per_cell = 1.0 / across.per_t, step = across.step();
  const int32_t padded = Crossings::padded(across.crossings());
  CIRCUMSPECT_NO_OVERLAP
  for (int32_t m = 0; m < padded; ++m) {
    const double crossing = (first + double(m) * step - across.at) * per_cell;
    const double after = crossing > start ? crossing : start;
    const double t = after < end ? after : end;
    ts[m] = t;
    cells[m] = along.cell(t);
  }
}

// One beam; `side` steps between columns by `side_stride`, layers by 1.
inline void walk_along(const Along& along, const Along& side, const Along& layer,
                       std::ptrdiff_t side_stride, double start, double end, Crossings& crossings,
                       Columns& columns) {
  crossings.sides = side.crossings();
  crossings.layers = layer.crossings();
  cross(side, along, start, end, crossings.t.data(), crossings.cell.data());
  cross(layer, along, start, end, crossings.t.data() + crossings.first_layer,
        crossings.cell.data() + crossings.first_layer);
  constexpr double kNoTurn = -1.0;
  const Walk walk{side.first * side_stride + layer.first,
                  side.step() * side_stride,
                  layer.step(),
                  start,
                  end,
                  along.first,
                  along.last,
                  kNoTurn,
                  0};
  columns.set(walk, crossings);
}

CIRCUMSPECT_MULTIVERSION
void walk_beams(const Box& grid, const Beams& b, int count, Crossings& crossings, Columns& along_x,
                Columns& along_y) {
  const Shape& shape = grid.shape;
  for (int n = 0; n < count; ++n) {
    const double start = b.start[n], end = b.end[n];
    if (!(start <= end)) continue;
    const Along x(b.ox[n], b.dx[n], grid.half_width, shape.i, start, end);
    const Along y(b.oy[n], b.dy[n], grid.half_width, shape.j, start, end);
    const Along z(b.oz[n], b.dz[n], grid.half_width, shape.k, start, end);
    if (x.crossings() >= y.crossings()) {
      walk_along(x, y, z, shape.k, start, end, crossings, along_x);
    } else {
      walk_along(y, x, z, shape.k, start, end, crossings, along_y);
    }
  }
}

}  // namespace

BoxTracer::BoxTracer(const Box& grid)
    : grid_(grid), along_x_(std::size_t(grid.shape.j) * std::size_t(grid.shape.k), grid.shape.i),
      along_y_(std::size_t(grid.shape.i) * std::size_t(grid.shape.k), grid.shape.j),
      crossings_(std::size_t(std::max(grid.shape.i, grid.shape.j)), std::size_t(grid.shape.k)) {}

void BoxTracer::trace(int count) {
  turn_and_clip(grid_, beams_, count);
  walk_beams(grid_, beams_, count, crossings_, along_x_, along_y_);
}

bool BoxTracer::passed(int32_t i, int32_t j, int32_t k) const {
  const std::size_t layers = std::size_t(grid_.shape.k), layer = std::size_t(k);
  return along_x_.get(std::size_t(j) * layers + layer, i) ||
         along_y_.get(std::size_t(i) * layers + layer, j);
}

}  // namespace circumspect
