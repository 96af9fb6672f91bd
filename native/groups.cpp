#include "groups.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "multiversion.hpp"

namespace circumspect {
namespace {

template <typename T>
[[gnu::always_inline]] inline void pack_each(const T* points_xyz, std::size_t count,
                                             const Packing& packing, int64_t* keys) {
  const T side = T(packing.side);
  const int64_t mask = (int64_t(1) << packing.bits) - 1;
  for (std::size_t n = 0; n < count; ++n) {
    int64_t key = 0;
    for (int a = 0; a < 3; ++a) {
      const T cell = std::floor(points_xyz[3 * n + a] / side);
      const int64_t whole = std::fabs(cell) < T(1e18) ? int64_t(cell) : 0;
      key = (key << packing.bits) | ((whole + packing.offset) & mask);
    }
    keys[n] = key;
  }
}

}  // namespace

CIRCUMSPECT_MULTIVERSION
void pack_cells(const double* points_xyz, std::size_t count, const Packing& packing,
                int64_t* keys) {
  pack_each(points_xyz, count, packing, keys);
}

CIRCUMSPECT_MULTIVERSION
void pack_cells(const float* points_xyz, std::size_t count, const Packing& packing, int64_t* keys) {
  pack_each(points_xyz, count, packing, keys);
}

Groups group(const int64_t* keys, std::size_t count) {
  KeyNumbers numbers(count);
  Groups found;
  found.of_row.resize(count);
  // First the groups in order of appearance.
  std::vector<int64_t> first;
  for (std::size_t n = 0; n < count; ++n) {
    if (n > 0 && keys[n] == keys[n - 1]) {
      found.of_row[n] = found.of_row[n - 1];
      continue;
    }
    found.of_row[n] = numbers.number(keys[n]);
    if (numbers.keys().size() > first.size()) first.push_back(int64_t(n));
  }
  const std::vector<int64_t>& some = numbers.keys();
  // Then the groups in order of their keys.
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

std::vector<int64_t> group_sizes(const int64_t* keys, std::size_t count) {
  KeyNumbers numbers(count);
  std::vector<int64_t> of_row(count), size(count, 0);
  for (std::size_t n = 0; n < count; ++n) {
    of_row[n] = n > 0 && keys[n] == keys[n - 1] ? of_row[n - 1] : numbers.number(keys[n]);
    ++size[std::size_t(of_row[n])];
  }
  for (int64_t& row : of_row) row = size[std::size_t(row)];
  return of_row;
}

std::vector<double> split_means(const Table& table, const int64_t* keys, std::size_t count) {
  KeyNumbers numbers(table.count);
  for (std::size_t n = 0; n < table.count; ++n) numbers.number(table.keys[n]);
  std::vector<int64_t> of_row(count);
  std::vector<double> size(table.count, 0.0);
  for (std::size_t n = 0; n < count; ++n) {
    of_row[n] = n > 0 && keys[n] == keys[n - 1] ? of_row[n - 1] : numbers.find(keys[n]);
    if (of_row[n] != KeyNumbers::kNone) size[std::size_t(of_row[n])] += 1.0;
  }
  std::vector<double> parts(count, 0.0);
  for (std::size_t n = 0; n < count; ++n) {
    if (of_row[n] == KeyNumbers::kNone) continue;
    const auto at = std::size_t(of_row[n]);
    parts[n] = table.totals[2 * at] / table.totals[2 * at + 1] / size[at];
  }
  return parts;
}

namespace {

// The number of rows in the sum of two tables.
std::size_t merged_count(const Table& one, const Table& other) {
  std::size_t a = 0, count = one.count;
  for (std::size_t b = 0; b < other.count; ++b) {
    const int64_t key = other.keys[b];
    if (b > 0 && key == other.keys[b - 1]) continue;
    while (a < one.count && one.keys[a] < key) ++a;
    if (a == one.count || one.keys[a] != key) ++count;
  }
  return count;
}

}  // namespace

MergedTable merged(const Table& one, const Table& other, std::size_t columns) {
  // Reserve exactly the size of the sum: tables are kept for long.
  const std::size_t rows = merged_count(one, other);
  MergedTable sum;
  sum.keys.reserve(rows);
  sum.totals.reserve(rows * columns);
  const auto take = [&](const Table& from, std::size_t begin, std::size_t end) {
    sum.keys.insert(sum.keys.end(), from.keys + begin, from.keys + end);
    sum.totals.insert(sum.totals.end(), from.totals + begin * columns, from.totals + end * columns);
  };
  std::size_t a = 0;
  for (std::size_t b = 0; b < other.count; ++b) {
    // Copy the rows of the first table between two rows of the second in one piece.
    const std::size_t begin = a;
    while (a < one.count && one.keys[a] <= other.keys[b]) ++a;
    take(one, begin, a);
    if (sum.keys.empty() || sum.keys.back() != other.keys[b]) {
      take(other, b, b + 1);
      continue;
    }
    double* row = sum.totals.data() + (sum.totals.size() - columns);
    for (std::size_t c = 0; c < columns; ++c) row[c] += other.totals[b * columns + c];
  }
  take(one, a, one.count);
  return sum;
}

}  // namespace circumspect
