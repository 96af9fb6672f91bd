#include "extent.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "block.hpp"
#include "multiversion.hpp"

namespace circumspect {
namespace {

using Axes = std::array<double, 3>;

constexpr int kValues = 3 * kBlock;

// Every place of a block has bounds and sums of its own, so that loops become vector code.
struct Bounds {
  alignas(64) double low[kValues], high[kValues], sum[kValues];
};

struct Products {
  alignas(64) double xx[kBlock], xy[kBlock], xz[kBlock], yy[kBlock], yz[kBlock], zz[kBlock];
};

// Far from the origin, sums of coordinates would lose digits; these are relative to `first`, the
// first row again and again.
CIRCUMSPECT_MULTIVERSION
void bound(const double* __restrict values, const double* __restrict first, int count,
           Bounds& __restrict found) {
  for (int n = 0; n < count; ++n) {
    const double value = values[n];
    found.low[n] = value < found.low[n] ? value : found.low[n];
    found.high[n] = value > found.high[n] ? value : found.high[n];
    found.sum[n] += value - first[n];
  }
}

CIRCUMSPECT_MULTIVERSION
void scale(const double* __restrict rows, const Axes& mean, double factor, int count,
           Block& __restrict block) {
  const double mx = mean[0], my = mean[1], mz = mean[2];
  for (int n = 0; n < count; ++n) {
    block.x[n] = (rows[3 * n] - mx) * factor;
    block.y[n] = (rows[3 * n + 1] - my) * factor;
    block.z[n] = (rows[3 * n + 2] - mz) * factor;
  }
}

CIRCUMSPECT_MULTIVERSION
void add_products(const Block& __restrict block, int count, Products& __restrict sums) {
  for (int n = 0; n < count; ++n) {
    const double x = block.x[n], y = block.y[n], z = block.z[n];
    sums.xx[n] += x * x, sums.xy[n] += x * y, sums.xz[n] += x * z;
    sums.yy[n] += y * y, sums.yz[n] += y * z, sums.zz[n] += z * z;
  }
}

// A power of two that brings `length` near 1: multiplying by it is fast and does not round.
double factor_of(double length) {
  return std::ldexp(1.0, -std::clamp(std::ilogb(length), -1000, 1000));
}

double total(const double* sums) { return std::accumulate(sums, sums + kBlock, 0.0); }

// Calls work(rows, count) for a block of rows after the other.
template <typename Work>
void for_each_block(const double* rows, std::size_t count, const Work& work) {
  for (std::size_t at = 0; at < count; at += kBlock) {
    work(rows + 3 * at, int(std::min<std::size_t>(kBlock, count - at)));
  }
}

}  // namespace

Extent extent(const double* points_xyz, std::size_t count) {
  alignas(64) double first[kValues];
  for (int n = 0; n < kValues; ++n) first[n] = points_xyz[n % 3];
  Bounds bounds{};
  std::copy_n(first, kValues, bounds.low);
  std::copy_n(first, kValues, bounds.high);
  for_each_block(points_xyz, count,
                 [&](const double* rows, int here) { bound(rows, first, 3 * here, bounds); });

  Extent found;
  Axes mean;
  double longest = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    found.low[a] = found.high[a] = first[a];
    double sum = 0.0;
    for (std::size_t n = a; n < kValues; n += 3) {
      found.low[a] = std::min(found.low[a], bounds.low[n]);
      found.high[a] = std::max(found.high[a], bounds.high[n]);
      sum += bounds.sum[n];
    }
    mean[a] = first[a] + sum / double(count);
    longest = std::max(longest, found.high[a] - found.low[a]);
  }
  if (!(longest > 0.0)) return found;

  const double factor = factor_of(longest);
  Block block;
  Products sums{};
  for_each_block(points_xyz, count, [&](const double* rows, int here) {
    scale(rows, mean, factor, here, block);
    add_products(block, here, sums);
  });
  const double xy = total(sums.xy), xz = total(sums.xz), yz = total(sums.yz);
  found.scatter = {total(sums.xx), xy, xz, xy, total(sums.yy), yz, xz, yz, total(sums.zz)};
  const double longest_scaled = longest * factor;
  for (double& value : found.scatter) value /= longest_scaled * longest_scaled;
  return found;
}

}  // namespace circumspect
