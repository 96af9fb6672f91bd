// Rows with equal keys: their groups, sums and tables of sums.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace circumspect {

// Numbers keys in order of first appearance, with a hash table.
class KeyNumbers {
 public:
  // `max_keys`: upper bound of the number of distinct keys.
  explicit KeyNumbers(std::size_t max_keys) {
    std::size_t capacity = 16;
    while (capacity < 2 * max_keys) capacity *= 2;
    slots_.assign(capacity, kNone);
  }

  static constexpr int64_t kNone = -1;

  // The number of a key; a new key gets the next number.
  int64_t number(int64_t key) {
    const std::size_t at = slot_of(key);
    if (slots_[at] == kNone) {
      slots_[at] = int64_t(keys_.size());
      keys_.push_back(key);
    }
    return slots_[at];
  }

  // The number of a known key, or `kNone`.
  int64_t find(int64_t key) const { return slots_[slot_of(key)]; }

  const std::vector<int64_t>& keys() const { return keys_; }

 private:
  std::size_t slot_of(int64_t key) const {
    const std::size_t last = slots_.size() - 1;
    uint64_t hash = uint64_t(key) * 0x9E3779B97F4A7C15ull;
    hash ^= hash >> 29;
    std::size_t at = hash & last;
    while (slots_[at] != kNone && keys_[std::size_t(slots_[at])] != key) at = (at + 1) & last;
    return at;
  }

  std::vector<int64_t> slots_, keys_;
};

// For each row the number of rows with the same key.
std::vector<int64_t> group_sizes(const int64_t* keys, std::size_t count);

// Groups of rows in ascending order of their keys.
struct Groups {
  std::vector<int64_t> keys;
  std::vector<int64_t> first;   // first row of each group
  std::vector<int64_t> of_row;  // group of each row
};

Groups group(const int64_t* keys, std::size_t count);

// Adds (n, columns) values to (groups, columns) totals, which the caller sets to zero.
template <typename T>
void add_rows(const int64_t* of_row, const T* values, std::size_t count, std::size_t columns,
              double* totals) {
  for (std::size_t n = 0; n < count; ++n) {
    double* row = totals + std::size_t(of_row[n]) * columns;
    const T* value = values + n * columns;
    for (std::size_t c = 0; c < columns; ++c) row[c] += double(value[c]);
  }
}

// How a cell becomes one key: three fields of `bits` bits, each with `offset` added, modulo 2^bits.
struct Packing {
  double side;
  int bits;
  int64_t offset;
};

// The key of each point's cell. The division has the precision of the points, as in NumPy.
void pack_cells(const double* points_xyz, std::size_t count, const Packing& packing, int64_t* keys);
void pack_cells(const float* points_xyz, std::size_t count, const Packing& packing, int64_t* keys);

// A table of ascending keys with rows of totals. Keys are unique unless stated otherwise.
struct Table {
  const int64_t* keys;
  const double* totals;
  std::size_t count;
};

struct MergedTable {
  std::vector<int64_t> keys;
  std::vector<double> totals;
};

// For a table with two columns, sum and count: the mean sum / count of each row's key, divided
// evenly among the rows with that key; 0 for keys that are not in the table.
std::vector<double> split_means(const Table& table, const int64_t* keys, std::size_t count);

// The sum of two tables. The second one may repeat keys; rows with equal keys are added in order.
MergedTable merged(const Table& one, const Table& other, std::size_t columns);

}  // namespace circumspect
