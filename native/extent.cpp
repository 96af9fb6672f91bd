#include "extent.hpp"

#include <algorithm>

namespace circumspect {

Extent extent(const double* points_xyz, std::size_t count) {
  Extent found;
  std::array<double, 3> sum{};
  std::copy_n(points_xyz, 3, found.low.begin());
  found.high = found.low;
  for (std::size_t n = 0; n < count; ++n) {
    for (std::size_t a = 0; a < 3; ++a) {
      const double value = points_xyz[3 * n + a];
      found.low[a] = std::min(found.low[a], value);
      found.high[a] = std::max(found.high[a], value);
      sum[a] += value - points_xyz[a];  // Far from the origin, sums would lose digits.
    }
  }
  double longest = 0.0;
  for (std::size_t a = 0; a < 3; ++a) longest = std::max(longest, found.high[a] - found.low[a]);
  if (!(longest > 0.0)) return found;
  std::array<double, 3> mean;
  for (std::size_t a = 0; a < 3; ++a) mean[a] = points_xyz[a] + sum[a] / double(count);
  for (std::size_t n = 0; n < count; ++n) {
    double away[3];
    for (std::size_t a = 0; a < 3; ++a) away[a] = (points_xyz[3 * n + a] - mean[a]) / longest;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) found.scatter[3 * a + b] += away[a] * away[b];
    }
  }
  return found;
}

}  // namespace circumspect
