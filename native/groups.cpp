#include "groups.hpp"

#include <algorithm>
#include <utility>

namespace circumspect {

Groups group(const int64_t* keys, std::size_t count) {
  std::size_t capacity = 16;
  while (capacity < 2 * count) capacity *= 2;
  std::vector<int64_t> slots(capacity, -1);
  Groups found;
  found.of_row.resize(count);
  // Groups in the order in which they come, …
  std::vector<int64_t> some, first;
  for (std::size_t n = 0; n < count; ++n) {
    if (n > 0 && keys[n] == keys[n - 1]) {
      found.of_row[n] = found.of_row[n - 1];
      continue;
    }
    uint64_t hash = uint64_t(keys[n]) * 0x9E3779B97F4A7C15ull;
    hash ^= hash >> 29;
    std::size_t at = hash & (capacity - 1);
    while (slots[at] >= 0 && some[std::size_t(slots[at])] != keys[n]) {
      at = (at + 1) & (capacity - 1);
    }
    if (slots[at] < 0) {
      slots[at] = int64_t(some.size());
      some.push_back(keys[n]), first.push_back(int64_t(n));
    }
    found.of_row[n] = slots[at];
  }
  // … then in the order of their keys.
  std::vector<std::pair<int64_t, std::size_t>> order(some.size());
  for (std::size_t n = 0; n < some.size(); ++n) order[n] = {some[n], n};
  std::sort(order.begin(), order.end());
  std::vector<int64_t> rank(some.size());
  found.keys.resize(some.size()), found.first.resize(some.size());
  for (std::size_t n = 0; n < order.size(); ++n) {
    rank[order[n].second] = int64_t(n);
    found.keys[n] = order[n].first, found.first[n] = first[order[n].second];
  }
  for (int64_t& of : found.of_row) of = rank[std::size_t(of)];
  return found;
}

MergedTable merged(const Table& one, const Table& other, std::size_t columns) {
  MergedTable sum;
  sum.keys.reserve(one.count + other.count);
  sum.totals.reserve((one.count + other.count) * columns);
  const auto take = [&](const Table& from, std::size_t n) {
    sum.keys.push_back(from.keys[n]);
    const double* row = from.totals + n * columns;
    sum.totals.insert(sum.totals.end(), row, row + columns);
  };
  std::size_t a = 0, b = 0;
  while (a < one.count || b < other.count) {
    if (b == other.count || (a < one.count && one.keys[a] < other.keys[b])) {
      take(one, a++);
    } else if (a == one.count || other.keys[b] < one.keys[a]) {
      take(other, b++);
    } else {
      take(one, a++);
      double* row = sum.totals.data() + (sum.totals.size() - columns);
      for (std::size_t c = 0; c < columns; ++c) row[c] += other.totals[b * columns + c];
      ++b;
    }
  }
  return sum;
}

std::size_t merged_rays(const Rays& one, const Rays& other, const RayOutput& out) {
  std::size_t a = 0, b = 0, n = 0;
  const auto take = [&](const Rays& from, std::size_t at, std::size_t count) {
    std::copy_n(from.keys + at, count, out.keys + n);
    std::copy_n(from.origins_xyz + 3 * at, 3 * count, out.origins_xyz + 3 * n);
    std::copy_n(from.ends_xyz + 3 * at, 3 * count, out.ends_xyz + 3 * n);
    std::copy_n(from.on_object + at, count, out.on_object + n);
    n += count;
  };
  // The second set is the smaller: between its rays, those of the first go in one piece.
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

}  // namespace circumspect
