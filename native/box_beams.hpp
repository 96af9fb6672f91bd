// Beams through a rectangular grid: exactly the cells they pass.
#pragma once

#include "beams.hpp"
#include "box.hpp"
#include "columns.hpp"

namespace circumspect {

// One a thread. A column is a row of cells along x or y, whichever a beam follows more closely: it
// crosses its sides and layers in order, and between two crossings its cells are those from one
// end to the other.
class BoxTracer {
 public:
  explicit BoxTracer(const Box& grid);

  // To be filled with o and d for `trace`.
  Beams& beams() { return beams_; }

  // Adds the cells of the first `count` beams.
  void trace(int count);

  // Whether any beam passed a cell.
  bool passed(int32_t i, int32_t j, int32_t k) const;

 private:
  const Box& grid_;
  Columns along_x_, along_y_;
  Crossings crossings_;
  Beams beams_;
};

}  // namespace circumspect
