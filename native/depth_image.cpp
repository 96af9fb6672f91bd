#include "depth_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "multiversion.hpp"

namespace circumspect {
namespace {

// How far neighbours may be apart; NaN where there is no depth, so that no comparison holds.
CIRCUMSPECT_MULTIVERSION
void allowed_steps(const float* __restrict depth, std::size_t count, const Noise& noise,
                   float spreads, float slope, float* __restrict allowed) {
  const Noise n = noise;
  for (std::size_t at = 0; at < count; ++at) {
    const float z = depth[at];
    const float spread = spreads * n.axial(z) + n.step * (z * z), going_on = z * slope;
    allowed[at] = spread > going_on ? spread : going_on;
  }
}

inline uint8_t joined(float z, float other, float limit, float other_limit) {
  return uint8_t(std::fabs(z - other) <= (limit < other_limit ? limit : other_limit));
}

// One row of pixels, between the rows above and below (null at the rims).
CIRCUMSPECT_MULTIVERSION
void continuous_row(const float* __restrict z, const float* __restrict limit,
                    const uint8_t* __restrict above, const uint8_t* __restrict below,
                    std::size_t width, uint8_t* __restrict along, bool* __restrict out) {
  along[0] = 0, along[width] = 0;
  for (std::size_t u = 1; u < width; ++u) {
    along[u] = joined(z[u - 1], z[u], limit[u - 1], limit[u]);
  }
  for (std::size_t u = 0; u < width; ++u) {
    out[u] = ((along[u] | along[u + 1]) & (above[u] | below[u])) != 0;
  }
}

CIRCUMSPECT_MULTIVERSION
void joined_rows(const float* __restrict z, const float* __restrict next,
                 const float* __restrict limit, const float* __restrict next_limit,
                 std::size_t width, uint8_t* __restrict out) {
  for (std::size_t u = 0; u < width; ++u) out[u] = joined(z[u], next[u], limit[u], next_limit[u]);
}

CIRCUMSPECT_MULTIVERSION
void keep_above_row(const float* __restrict depth, const float* __restrict along, std::size_t width,
                    float base, float height, const Noise& noise, float margin, float sigmas,
                    float farthest, bool* __restrict mask) {
  const Noise n = noise;
  for (std::size_t u = 0; u < width; ++u) {
    const float z = depth[u], up = base + along[u];
    const float axial = n.axial(z), step = n.step * (z * z);
    const float sigma = std::fabs(up) * std::sqrt(axial * axial + step * step / 12.0f);
    mask[u] = mask[u] & (z <= farthest) & (z * up + height > margin + sigmas * sigma);
  }
}

}  // namespace

void block_means(const float* depth, const bool* mask, Size size, std::size_t block, float jump,
                 float* mean, int32_t* counts) {
  const std::size_t columns = (size.width + block - 1) / block;
  const std::size_t rows = (size.height + block - 1) / block;
  std::vector<float> total(columns), highest(columns), lowest(columns);
  const float infinity = std::numeric_limits<float>::infinity();
  for (std::size_t row = 0; row < rows; ++row, mean += columns, counts += columns) {
    std::fill(total.begin(), total.end(), 0.0f);
    std::fill(highest.begin(), highest.end(), 0.0f);
    std::fill(lowest.begin(), lowest.end(), infinity);
    std::fill(counts, counts + columns, 0);
    for (std::size_t v = row * block; v < std::min(size.height, (row + 1) * block); ++v) {
      const float* line = depth + v * size.width;
      const bool* wanted = mask == nullptr ? nullptr : mask + v * size.width;
      for (std::size_t column = 0, u = 0; column < columns; ++column) {
        for (const std::size_t end = std::min(size.width, u + block); u < end; ++u) {
          const float z = line[u];
          if (!(z > 0.0f && z < infinity) || (wanted != nullptr && !wanted[u])) continue;
          const float q = 1.0f / z;
          total[column] += q, counts[column] += 1;
          highest[column] = std::max(highest[column], q);
          lowest[column] = std::min(lowest[column], q);
        }
      }
    }
    for (std::size_t c = 0; c < columns; ++c) {
      if (counts[c] > 0 && highest[c] - lowest[c] > 2.0f * jump * highest[c]) counts[c] = 0;
      mean[c] = counts[c] > 0 ? float(double(total[c]) / counts[c])
                              : std::numeric_limits<float>::quiet_NaN();
    }
  }
}

void continuous(const float* depth, Size size, const Noise& noise, float spreads, float slope,
                bool* out) {
  const std::size_t width = size.width;
  std::vector<float> allowed(2 * width);
  std::vector<uint8_t> above(width, 0), below(width, 0), along(width + 1);
  float *here = allowed.data(), *next = here + width;
  if (size.height > 0) allowed_steps(depth, width, noise, spreads, slope, here);
  for (std::size_t v = 0; v < size.height; ++v, depth += width, out += width) {
    if (v + 1 < size.height) {
      allowed_steps(depth + width, width, noise, spreads, slope, next);
      joined_rows(depth, depth + width, here, next, width, below.data());
    } else {
      std::fill(below.begin(), below.end(), uint8_t(0));
    }
    continuous_row(depth, here, above.data(), below.data(), width, along.data(), out);
    std::swap(above, below);
    std::swap(here, next);
  }
}

void keep_above(const float* depth, Size size, const Rise& rise, const Noise& noise, float margin,
                float sigmas, float farthest, bool* mask) {
  std::vector<float> along(size.width);
  for (std::size_t u = 0; u < size.width; ++u) {
    along[u] = rise.x * ((float(u) - rise.cx) / rise.fx);
  }
  for (std::size_t v = 0; v < size.height; ++v) {
    const float base = rise.z + rise.y * ((float(v) - rise.cy) / rise.fy);
    keep_above_row(depth + v * size.width, along.data(), size.width, base, rise.height, noise,
                   margin, sigmas, farthest, mask + v * size.width);
  }
}

namespace {

// Calls visit(v, u, first masked pixel, masked pixels) for every block with masked pixels.
template <typename Visit>
void for_each_block(const bool* mask, Size size, std::size_t block, const Visit& visit) {
  for (std::size_t v = 0; v < size.height; v += block) {
    const std::size_t to_v = std::min(size.height, v + block);
    for (std::size_t u = 0; u < size.width; u += block) {
      const std::size_t to_u = std::min(size.width, u + block);
      std::size_t first = 0;
      int64_t count = 0;
      for (std::size_t row = v; row < to_v; ++row) {
        for (std::size_t at = row * size.width + u; at < row * size.width + to_u; ++at) {
          if (mask[at] && count++ == 0) first = at;
        }
      }
      if (count > 0 && !visit(v, u, first, count)) return;
    }
  }
}

}  // namespace

PlanCells plan_cells(const float* depth, const bool* mask, Size size, const double* camera,
                     const double* T, double cell, std::size_t most, std::size_t block) {
  const auto [fx, fy, cx, cy] = std::array<double, 4>{camera[0], camera[1], camera[2], camera[3]};
  PlanCells found;
  std::vector<double> xs, ys;
  std::vector<int64_t> pixels;
  double low_x = 0.0, low_y = 0.0, high_x = 0.0, high_y = 0.0;
  bool is_finite = true;
  for_each_block(mask, size, block, [&](std::size_t, std::size_t, std::size_t at, int64_t count) {
    const double b = (double(at / size.width) - cy) / fy, a = (double(at % size.width) - cx) / fx;
    const double z = double(depth[at]);
    const double x = (T[0] * a + T[1] * b + T[2]) * z + T[3];
    const double y = (T[4] * a + T[5] * b + T[6]) * z + T[7];
    // std::min and std::max would pass over NaN, which no cell holds.
    is_finite = std::isfinite(x + y);
    if (xs.empty()) low_x = high_x = x, low_y = high_y = y;
    low_x = std::min(low_x, x), high_x = std::max(high_x, x);
    low_y = std::min(low_y, y), high_y = std::max(high_y, y);
    xs.push_back(x), ys.push_back(y), pixels.push_back(count);
    return is_finite;
  });
  if (!is_finite) return found;
  found.low_x = low_x - 2.0 * cell, found.low_y = low_y - 2.0 * cell;
  const double rows = (high_x - found.low_x) / cell + 3.0;
  const double columns = (high_y - found.low_y) / cell + 3.0;
  if (!(rows * columns <= double(most))) return found;
  found.rows = std::size_t(rows), found.columns = std::size_t(columns);
  found.cell.resize(xs.size());
  found.counts.assign(found.rows * found.columns, 0);
  for (std::size_t n = 0; n < xs.size(); ++n) {
    const std::size_t i = std::size_t((xs[n] - found.low_x) / cell);
    const std::size_t j = std::size_t((ys[n] - found.low_y) / cell);
    found.cell[n] = int32_t(i * found.columns + j);
    found.counts[i * found.columns + j] += pixels[n];
  }
  return found;
}

std::size_t masked_blocks(const bool* mask, Size size, std::size_t block) {
  std::size_t total = 0;
  for_each_block(mask, size, block, [&](std::size_t, std::size_t, std::size_t, int64_t) {
    ++total;
    return true;
  });
  return total;
}

void keep_cells(const int32_t* cell, const bool* wanted, Size size, std::size_t block, bool* mask) {
  for_each_block(mask, size, block, [&](std::size_t v, std::size_t u, std::size_t, int64_t) {
    if (wanted[*cell++]) return true;
    for (std::size_t row = v; row < std::min(size.height, v + block); ++row) {
      std::fill(mask + row * size.width + u,
                mask + row * size.width + std::min(size.width, u + block), false);
    }
    return true;
  });
}

}  // namespace circumspect
