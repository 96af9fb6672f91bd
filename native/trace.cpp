#include "trace.hpp"

#include "multiversion.hpp"

namespace circumspect {

CIRCUMSPECT_MULTIVERSION
void to_beams(const Block& origins, const Block& ends, double x, double y, double z, Beams& beams,
              int count) {
  for (int n = 0; n < count; ++n) {
    beams.ox[n] = origins.x[n] - x;
    beams.oy[n] = origins.y[n] - y;
    beams.oz[n] = origins.z[n] - z;
    beams.dx[n] = ends.x[n] - origins.x[n];
    beams.dy[n] = ends.y[n] - origins.y[n];
    beams.dz[n] = ends.z[n] - origins.z[n];
  }
}

}  // namespace circumspect
