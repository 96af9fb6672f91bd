#include "merged_rays.hpp"

#include <algorithm>

namespace circumspect {

std::size_t merged_rays(const Rays& one, const Rays& other, const RayOutput& out) {
  std::size_t a = 0, b = 0, n = 0;
  const auto take = [&](const Rays& from, std::size_t at, std::size_t count) {
    std::copy_n(from.keys + at, count, out.keys + n);
    std::copy_n(from.origins_xyz + 3 * at, 3 * count, out.origins_xyz + 3 * n);
    std::copy_n(from.ends_xyz + 3 * at, 3 * count, out.ends_xyz + 3 * n);
    std::copy_n(from.on_object + at, count, out.on_object + n);
    n += count;
  };
  // The second set is smaller: copy the rays of the first between two of its rays in one piece.
  for (; b < other.count; ++b) {
    const int64_t key = other.keys[b];
    const int64_t* next = std::lower_bound(one.keys + a, one.keys + one.count, key);
    const std::size_t to = std::size_t(next - one.keys);
    if (to > a) take(one, a, to - a);
    a = to;
    if (a == one.count || one.keys[a] != key) take(other, b, 1);
  }
  if (one.count > a) take(one, a, one.count - a);
  return n;
}

bool added_keys(const int64_t* known, std::size_t known_count, const int64_t* all,
                std::size_t all_count, std::vector<int64_t>& rows) {
  if (known_count > all_count) return false;
  rows.reserve(all_count - known_count);
  std::size_t k = 0;
  for (std::size_t n = 0; n < all_count; ++n) {
    if (k < known_count && known[k] < all[n]) return false;
    if (k < known_count && known[k] == all[n]) {
      ++k;
    } else {
      rows.push_back(int64_t(n));
    }
  }
  return k == known_count;
}

}  // namespace circumspect
