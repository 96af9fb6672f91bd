#include "block.hpp"

#include <algorithm>
#include <limits>

#include "multiversion.hpp"

namespace circumspect {
namespace {

template <typename T>
inline void split(const T* __restrict rows, int count, double* __restrict x, double* __restrict y,
                  double* __restrict z) {
  for (int n = 0; n < count; ++n) {
    x[n] = double(rows[3 * n]);
    y[n] = double(rows[3 * n + 1]);
    z[n] = double(rows[3 * n + 2]);
  }
}

template <typename T>
inline bool all_usable(const T* rows, int values) {
  const T largest = T(std::min(kLargestCoordinate, double(std::numeric_limits<T>::max())));
  int usable = 1;
  for (int n = 0; n < values; ++n) usable &= int(std::fabs(rows[n]) <= largest);  // not for NaN
  return usable != 0;
}

template <typename T>
int64_t unusable_rows(const T* rows, int count) {
  int64_t bad = 0;
  for (int n = 0; n < count; ++n) bad += !all_usable(rows + 3 * n, 3);
  return bad;
}

CIRCUMSPECT_MULTIVERSION
bool all_rows_usable(const double* rows, int count) { return all_usable(rows, 3 * count); }

CIRCUMSPECT_MULTIVERSION
bool all_rows_usable(const float* rows, int count) { return all_usable(rows, 3 * count); }

template <typename T>
int64_t unusable_of_all(const T* rows, std::size_t count) {
  int64_t bad = 0;
  for (std::size_t at = 0; at < count; at += kBlock) {
    const int here = int(std::min<std::size_t>(kBlock, count - at));
    if (!all_rows_usable(rows + 3 * at, here)) bad += unusable_rows(rows + 3 * at, here);
  }
  return bad;
}

CIRCUMSPECT_MULTIVERSION
bool split_rows(const double* rows, int count, Block& block) {
  split(rows, count, block.x, block.y, block.z);
  return all_usable(rows, 3 * count);
}

CIRCUMSPECT_MULTIVERSION
bool split_rows(const float* rows, int count, Block& block) {
  split(rows, count, block.x, block.y, block.z);
  return all_usable(rows, 3 * count);
}

}  // namespace

int64_t load(const double* rows, int count, Block& block) {
  return split_rows(rows, count, block) ? 0 : unusable_rows(rows, count);
}

int64_t load(const float* rows, int count, Block& block) {
  return split_rows(rows, count, block) ? 0 : unusable_rows(rows, count);
}

int64_t unusable(const double* rows, std::size_t count) { return unusable_of_all(rows, count); }

int64_t unusable(const float* rows, std::size_t count) { return unusable_of_all(rows, count); }

}  // namespace circumspect
