#include "box.hpp"

#include "multiversion.hpp"

namespace circumspect {
namespace {

struct Axis {
  double per_half_width, half_cells, last;
};

inline int32_t cell_along(const Axis& axis, double at) {
  const double up = cells_from_side(at, axis.per_half_width, axis.half_cells);
  const double t = up > 0.0 ? up : 0.0;
  return int32_t(t < axis.last ? t : axis.last);
}

CIRCUMSPECT_MULTIVERSION
void locate_in(const Box& box, const Axis& ai, const Axis& aj, const Axis& ak, Block& block,
               int count) {
  const double half_width = box.half_width;
  for (int n = 0; n < count; ++n) {
    const double dx = block.x[n] - box.x, dy = block.y[n] - box.y, z = block.z[n] - box.z;
    const double x = box.cosine * dx + box.sine * dy;
    const double y = box.cosine * dy - box.sine * dx;
    const double ax = std::fabs(x), ay = std::fabs(y), az = std::fabs(z);
    const double wide = ax > ay ? ax : ay, widest = wide > az ? wide : az;
    const int32_t outside = int32_t(widest <= half_width ? 0.0 : -1.0);
    block.i[n] = cell_along(ai, x) | outside;
    block.j[n] = cell_along(aj, y) | outside;
    block.k[n] = cell_along(ak, z) | outside;
  }
}

}  // namespace

void Box::locate(Block& block, int count) const {
  const auto axis = [this](int32_t cells) {
    return Axis{1.0 / half_width, 0.5 * cells, double(cells - 1)};
  };
  locate_in(*this, axis(shape.i), axis(shape.j), axis(shape.k), block, count);
}

}  // namespace circumspect
