// Points by the cubic cell that they lie in, found by a hash of the cell.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace circumspect {

class CellTable {
 public:
  struct Slot {
    uint64_t key;
    int32_t begin, end;  // places in `order`; begin == end: a slot that is not used
  };

  // (count, 3) points, fewer than 2³¹. Cells repeat after 2²¹ along an axis: callers check
  // distances.
  CellTable(const double* points_xyz, std::size_t count, double side);

  // The points' numbers, cell by cell, ascending within each.
  const std::vector<int32_t>& order() const { return order_; }

  const std::vector<Slot>& slots() const { return slots_; }

  // The points of a cell, or null where there are none.
  const Slot* find(int64_t i, int64_t j, int64_t k) const {
    const uint64_t key = key_of(i, j, k);
    const std::size_t last = slots_.size() - 1;
    for (std::size_t at = mixed(key) & last;; at = (at + 1) & last) {
      const Slot& slot = slots_[at];
      if (slot.begin == slot.end) return nullptr;
      if (slot.key == key) return &slot;
    }
  }

  // A coordinate in cells, and the cell that it lies in.
  double in_cells(double coordinate) const { return coordinate * per_metre_; }
  int64_t cell_of(double coordinate) const { return int64_t(std::floor(in_cells(coordinate))); }

 private:
  static uint64_t key_of(int64_t i, int64_t j, int64_t k) {
    constexpr int kBits = 21;
    constexpr uint64_t kMask = (uint64_t(1) << kBits) - 1;
    return ((uint64_t(i) & kMask) << (2 * kBits)) | ((uint64_t(j) & kMask) << kBits) |
           (uint64_t(k) & kMask);
  }

  static uint64_t mixed(uint64_t key) {
    key *= 0x9E3779B97F4A7C15ull;
    return key ^ (key >> 29);
  }

  double per_metre_;
  std::vector<Slot> slots_;
  std::vector<int32_t> order_;
};

}  // namespace circumspect
