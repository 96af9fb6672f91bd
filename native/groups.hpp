// Rows with equal keys: which belong together, and their sums.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace circumspect {

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

// A table of ascending keys, each once, with rows of totals.
struct Table {
  const int64_t* keys;
  const double* totals;
  std::size_t count;
};

struct MergedTable {
  std::vector<int64_t> keys;
  std::vector<double> totals;
};

// The sum of two tables.
MergedTable merged(const Table& one, const Table& other, std::size_t columns);

}  // namespace circumspect
