// A few beams at a time, one number an array, about the centre of a grid.
#pragma once

#include <cstdint>

namespace circumspect {

constexpr int kBeams = 128;

// From o (t = 0) to o + d (t = 1) [m].
struct Beams {
  alignas(64) double ox[kBeams], oy[kBeams], oz[kBeams];
  alignas(64) double dx[kBeams], dy[kBeams], dz[kBeams];
  // The part within the grid's bounds; start > end for a beam that misses them.
  alignas(64) double start[kBeams], end[kBeams];
};

// Narrows [start, end] to where o + t d lies within ±half_width. Written without branches.
inline void clip(double o, double d, double half_width, double& start, double& end) {
  const double divisor = d != 0.0 ? d : 1.0;
  const double a = (-half_width - o) / divisor, b = (half_width - o) / divisor;
  const double low = a < b ? a : b, high = a < b ? b : a;
  // Parallel to the sides: all of the beam or none.
  const double aside = half_width - (o < 0.0 ? -o : o);
  const double parallel_from = aside >= 0.0 ? 0.0 : 2.0;
  const double from = d != 0.0 ? low : parallel_from;
  const double to = d != 0.0 ? high : 1.0;
  start = from > start ? from : start;
  end = to < end ? to : end;
}

// The number of the cell at `at` cells from the first boundary, rounding left to the caller.
inline double cell_at(double at, double last) {
  const double up = at > 0.0 ? at : 0.0;
  return up < last ? up : last;
}

}  // namespace circumspect
