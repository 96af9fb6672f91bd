// Beams through a cylindrical grid: exactly the cells they pass.
#pragma once

#include <memory>

#include "beams.hpp"
#include "columns.hpp"
#include "cylinder.hpp"

namespace circumspect {

// One a thread. A column is all rings of one sector and layer: a beam crosses half-planes in the
// order of its sweep, layers in the order of its rise, and between two crossings its rings are
// those from one end to the other, or down to where it passes the axis and up again.
class CylinderTracer {
 public:
  explicit CylinderTracer(const Cylinder& grid);
  ~CylinderTracer();

  // To be filled with o and d for `trace`.
  Beams& beams();

  // Adds the cells of the first `count` beams.
  void trace(int count);

  // Whether any beam passed a cell.
  bool passed(int32_t i, int32_t j, int32_t k) const;

 private:
  struct Scratch;
  const Cylinder& grid_;
  Columns columns_;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace circumspect
