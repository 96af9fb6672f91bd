// Free cells as bits. A beam crosses a column of cells (all rings of one sector and layer, say) in
// one run of neighbours. So it need not be followed cell by cell: it goes from column to column,
// exactly where it crosses their sides, and each run is written at once.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace circumspect {

// Where a beam crosses the sides of columns: when, and in which cell it then is. There are two
// kinds, each in order: sides from 0 on, layers from `first_layer` on.
struct Crossings {
  Crossings(std::size_t most_sides, std::size_t most_layers)
      : first_layer(most_sides + kSpare), t(most_sides + most_layers + 2 * kSpare),
        cell(most_sides + most_layers + 2 * kSpare) {}

  // Crossings are found eight at a time, so that a few more are written than counted.
  static int32_t padded(int32_t count) { return (count + 7) & ~7; }
  static constexpr std::size_t kSpare = 16;

  const std::size_t first_layer;
  std::vector<double> t;
  std::vector<int32_t> cell;
  int32_t sides = 0, layers = 0;  // how many
};

// A beam within the grid, from column to column.
struct Walk {
  std::ptrdiff_t column;                 // the first
  std::ptrdiff_t side_step, layer_step;  // to the next column, by kind of crossing
  double start, end;                     // parameter of the beam
  int32_t first_cell, last_cell;         // where in the columns it is at start and end
  double turn;                           // here it reaches turn_cell, the smallest of all; a turn
  int32_t turn_cell;                     // outside start … end does not count
};

// `count` columns of `length` cells each.
class Columns {
 public:
  Columns(std::size_t count, int32_t length)
      : words_((std::size_t(length) + 63) / 64), bits_(count * words_) {
    for (std::size_t n = 1; n < below_.size(); ++n) below_[n] = below_[n - 1] << 1 | 1;
  }

  bool get(std::size_t column, int32_t cell) const {
    return bits_[column * words_ + std::size_t(cell / 64)] >> (cell % 64) & 1;
  }

  // Sets the cells of a walk. Writes an end behind the crossings of either kind.
  void set(const Walk& walk, Crossings& crossings) {
    constexpr double kNever = 1e300;
    crossings.t[std::size_t(crossings.sides)] = kNever;
    crossings.t[crossings.first_layer + std::size_t(crossings.layers)] = kNever;
    if (words_ == 1) {
      set_short(walk, crossings);
    } else {
      set_long(walk, crossings);
    }
  }

 private:
  // Columns of one word. Runs come from masks of the cells below: the smaller of two cells has
  // the intersection of both masks, the larger one their union. No branch depends on the beam.
  void set_short(const Walk& walk, const Crossings& crossings) {
    const double* const ts = crossings.t.data();
    const int32_t* const cells = crossings.cell.data();
    uint64_t* bits = bits_.data() + walk.column;
    const uint64_t below_turn = below_[std::size_t(walk.turn_cell)];
    const std::ptrdiff_t other_step = walk.side_step - walk.layer_step;
    uint64_t before = below_[std::size_t(walk.first_cell)];
    std::size_t side = 0, layer = crossings.first_layer;
    double since = walk.start;
    for (int32_t left = crossings.sides + crossings.layers; left > 0; --left) {
      const std::size_t is_side = ts[side] <= ts[layer];
      const std::size_t next = layer + ((side - layer) & (0 - is_side));
      const uint64_t now = below_[std::size_t(cells[next])];
      *bits |= run(before, now, since, ts[next], walk.turn, below_turn);
      bits += walk.layer_step + (other_step & -std::ptrdiff_t(is_side));
      side += is_side;
      layer += 1 - is_side;
      since = ts[next];
      before = now;
    }
    const uint64_t now = below_[std::size_t(walk.last_cell)];
    *bits |= run(before, now, since, walk.end, walk.turn, below_turn);
  }

  static uint64_t run(uint64_t a, uint64_t b, double from, double to, double turn,
                      uint64_t below_turn) {
    const uint64_t turns = -uint64_t((from < turn) & (turn < to));
    return ((a | b) << 1 | 1) & ~(a & b & (below_turn | ~turns));
  }

  void set_long(const Walk& walk, const Crossings& crossings) {
    std::size_t side = 0, layer = crossings.first_layer;
    std::ptrdiff_t column = walk.column;
    int32_t before = walk.first_cell;
    double since = walk.start;
    for (int32_t left = crossings.sides + crossings.layers; left >= 0; --left) {
      const bool is_side = crossings.t[side] <= crossings.t[layer];
      const std::size_t next = is_side ? side++ : layer++;
      const double t = left > 0 ? crossings.t[next] : walk.end;
      const int32_t now = left > 0 ? crossings.cell[next] : walk.last_cell;
      const bool turns = since < walk.turn && walk.turn < t;
      set_run(column, turns ? walk.turn_cell : std::min(before, now), std::max(before, now));
      column += is_side ? walk.side_step : walk.layer_step;
      since = t;
      before = now;
    }
  }

  void set_run(std::ptrdiff_t column, int32_t first, int32_t last) {
    uint64_t* words = bits_.data() + std::size_t(column) * words_;
    for (int32_t word = first / 64; word <= last / 64; ++word) {
      const uint64_t from = word * 64 < first ? below_[std::size_t(first % 64)] : 0;
      words[word] |= below_[std::size_t(std::min(last - word * 64, 63) + 1)] & ~from;
    }
  }

  std::size_t words_;
  std::vector<uint64_t> bits_;
  std::array<uint64_t, 65> below_{};  // n bits set
};

}  // namespace circumspect
