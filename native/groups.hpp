// Rows with equal keys: which belong together, and their sums.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace circumspect {

// Numbers keys in the order in which they come, by a hash of each.
class KeyNumbers {
 public:
  // Room for so many different keys.
  explicit KeyNumbers(std::size_t most) {
    std::size_t capacity = 16;
    while (capacity < 2 * most) capacity *= 2;
    slots_.assign(capacity, kNone);
  }

  static constexpr int64_t kNone = -1;

  // The number of a key, which is the next one where the key is new.
  int64_t number(int64_t key) {
    const std::size_t at = slot_of(key);
    if (slots_[at] == kNone) {
      slots_[at] = int64_t(keys_.size());
      keys_.push_back(key);
    }
    return slots_[at];
  }

  // The number of a key that came already, or `kNone`.
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

// How many rows have the key of each row.
std::vector<int64_t> crowds(const int64_t* keys, std::size_t count);

// Groups of rows in ascending order of their keys.
struct Groups {
  std::vector<int64_t> keys;
  std::vector<int64_t> first;   // a group's first row
  std::vector<int64_t> of_row;  // a row's group
};

Groups group(const int64_t* keys, std::size_t count);

// Adds (n, columns) values up into (groups, columns) totals, which begin at zero.
template <typename T>
void add_rows(const int64_t* of_row, const T* values, std::size_t count, std::size_t columns,
              double* totals) {
  for (std::size_t n = 0; n < count; ++n) {
    double* row = totals + std::size_t(of_row[n]) * columns;
    const T* value = values + n * columns;
    for (std::size_t c = 0; c < columns; ++c) row[c] += double(value[c]);
  }
}

// How points' cells become one number: three fields of `bits`, each offset and cut to its bits.
struct Packing {
  double side;
  int bits;
  int64_t offset;
};

// The number of each point's cell, in the points' own precision, as NumPy divides.
void pack_cells(const double* points_xyz, std::size_t count, const Packing& packing,
                int64_t* keys);
void pack_cells(const float* points_xyz, std::size_t count, const Packing& packing, int64_t* keys);

// A table of ascending keys with rows of totals; each key once where nothing else is said.
struct Table {
  const int64_t* keys;
  const double* totals;
  std::size_t count;
};

struct MergedTable {
  std::vector<int64_t> keys;
  std::vector<double> totals;
};

// Of a table of sums of area and frames: the mean area of a row's key in equal parts for all rows
// of that key, and none for keys that are not in the table.
std::vector<double> mean_shares(const Table& table, const int64_t* keys, std::size_t count);

// Rays with ascending keys, each once.
struct Rays {
  const int64_t* keys;
  const float *origins_xyz, *ends_xyz;
  const bool* on_object;
  std::size_t count;
};

// Rays of two sets; of equal keys the first set's. The arrays of `out` have room for all.
struct RayOutput {
  int64_t* keys;
  float *origins_xyz, *ends_xyz;
  bool* on_object;
};
std::size_t merged_rays(const Rays& one, const Rays& other, const RayOutput& out);

// The sum of two tables. Keys of the second one may come several times; rows of a key are added in
// the order in which they come.
MergedTable merged(const Table& one, const Table& other, std::size_t columns);

}  // namespace circumspect
