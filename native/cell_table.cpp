#include "cell_table.hpp"

namespace circumspect {

CellTable::CellTable(const double* points_xyz, std::size_t count, double side)
    : per_metre_(1.0 / side), order_(count) {
  std::size_t capacity = 16;
  while (capacity < 2 * count) capacity *= 2;
  slots_.assign(capacity, Slot{0, 0, 0});
  // First how many there are in each cell, then where each cell begins, then the points.
  std::vector<std::size_t> slot_of(count);
  for (std::size_t n = 0; n < count; ++n) {
    const double* p = points_xyz + 3 * n;
    const uint64_t key = key_of(cell_of(p[0]), cell_of(p[1]), cell_of(p[2]));
    std::size_t at = mixed(key) & (capacity - 1);
    while (slots_[at].end > 0 && slots_[at].key != key) at = (at + 1) & (capacity - 1);
    slots_[at].key = key, slots_[at].end += 1;
    slot_of[n] = at;
  }
  int32_t begin = 0;
  for (Slot& slot : slots_) {
    const int32_t here = slot.end;
    slot.begin = slot.end = begin;
    begin += here;
  }
  for (std::size_t n = 0; n < count; ++n) {
    order_[std::size_t(slots_[slot_of[n]].end++)] = int32_t(n);
  }
}

}  // namespace circumspect
