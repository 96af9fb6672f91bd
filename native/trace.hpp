// Beams into cells: which cells they passed.
#pragma once

#include <algorithm>
#include <atomic>

#include "beams.hpp"
#include "block.hpp"
#include "hits.hpp"
#include "parallel.hpp"

namespace circumspect {

constexpr std::size_t kBeamsPerThread = 2048;

// About the centre of the grid; x, y, z of the blocks are origins and ends.
void to_beams(const Block& origins, const Block& ends, double x, double y, double z, Beams& beams,
              int count);

// Origins and ends of a few beams at a time. One origin stands for all where `origin_count` is 1.
template <typename T>
class BeamRows {
 public:
  BeamRows(const T* origins_xyz, std::size_t origin_count, const T* ends_xyz)
      : origins_xyz_(origins_xyz), origin_count_(origin_count), ends_xyz_(ends_xyz) {
    if (origin_count != 1) return;
    T rows[3 * kBeams];
    for (int n = 0; n < 3 * kBeams; ++n) rows[n] = origins_xyz[n % 3];
    bad_ += load(rows, kBeams, origins) > 0;
  }

  // Loads `here` beams from number `at` on; false as soon as any were not usable: the caller will
  // refuse all.
  bool load_from(std::size_t at, int here) {
    if (origin_count_ > 1) bad_ += load(origins_xyz_ + 3 * at, here, origins);
    bad_ += load(ends_xyz_ + 3 * at, here, ends);
    return bad_ == 0;
  }

  int64_t bad() const { return bad_; }

  Block origins, ends;

 private:
  const T* origins_xyz_;
  std::size_t origin_count_;
  const T* ends_xyz_;
  int64_t bad_ = 0;
};

// Writes `value` into each cell that a tracer's beams passed.
template <typename Tracer>
void mark_cells(const Tracer& tracer, const Shape& shape, uint8_t value, uint8_t* state) {
  for (int32_t i = 0; i < shape.i; ++i) {
    for (int32_t j = 0; j < shape.j; ++j) {
      for (int32_t k = 0; k < shape.k; ++k, ++state) {
        if (tracer.passed(i, j, k)) mark(state, value);
      }
    }
  }
}

// Writes `value` into each cell that a beam passed, its last cell included. One origin stands for
// all where `origin_count` is 1. Returns how many beams were not usable.
template <typename Tracer, typename Grid, typename T>
int64_t mark_passed(const Grid& grid, const T* origins_xyz, std::size_t origin_count,
                    const T* ends_xyz, std::size_t count, uint8_t value, uint8_t* states,
                    std::size_t threads) {
  std::atomic<int64_t> bad{0};
  parallel_for(count, threads, kBeamsPerThread, [&](std::size_t begin, std::size_t end) {
    Tracer tracer(grid);
    BeamRows<T> rows(origins_xyz, origin_count, ends_xyz);
    for (std::size_t at = begin; at < end; at += kBeams) {
      const int here = int(std::min<std::size_t>(kBeams, end - at));
      if (!rows.load_from(at, here)) continue;
      to_beams(rows.origins, rows.ends, grid.x, grid.y, grid.z, tracer.beams(), here);
      tracer.trace(here);
    }
    bad += rows.bad();
    mark_cells(tracer, grid.shape, value, states);
  });
  return bad;
}

}  // namespace circumspect
