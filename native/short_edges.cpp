#include "short_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "cell_table.hpp"
#include "median.hpp"
#include "multiversion.hpp"

namespace circumspect {
namespace {

// Points on several sheets that nearly coincide (thin walls, doubled faces) come in clusters, with
// a jump in the distances from the last neighbour in the cluster to the first one outside of it.
constexpr std::size_t kLargestCluster = 6;
constexpr double kJump = 1.45;  // More than the square root of 2, the largest in a regular grid.
constexpr std::size_t kSample = 512;
constexpr double kSmallestCell = 1e-6;  // So that the cells of an extent near 1 do not repeat.
constexpr double kRounding = 1 + 1e-9;  // No point within reach lies two cells on.
constexpr double kFar = std::numeric_limits<double>::infinity();

CIRCUMSPECT_MULTIVERSION
void distances(const double* x, const double* y, const double* z, std::size_t count,
               const double* from, double* out) {
  const double fx = from[0], fy = from[1], fz = from[2];
  CIRCUMSPECT_NO_OVERLAP
  for (std::size_t n = 0; n < count; ++n) {
    const double dx = fx - x[n], dy = fy - y[n], dz = fz - z[n];
    out[n] = std::sqrt(dx * dx + dy * dy + dz * dz);
  }
}

// Points side by side, whose distances from one place are found at once.
class Together {
 public:
  void clear() { x_.clear(), y_.clear(), z_.clear(); }

  void add(const double* point) {
    x_.push_back(point[0]), y_.push_back(point[1]), z_.push_back(point[2]);
  }

  // From a place to the points from number `first` on; holds until the next call.
  const double* distances_from(const double* place, std::size_t first = 0) {
    away_.resize(x_.size());
    distances(x_.data() + first, y_.data() + first, z_.data() + first, x_.size() - first, place,
              away_.data());
    return away_.data();
  }

 private:
  std::vector<double> x_, y_, z_, away_;
};

// The smallest of some distances, ascending; infinite where there are fewer.
std::array<double, kLargestCluster> smallest(const double* away, std::size_t count,
                                             std::size_t leave_out) {
  std::array<double, kLargestCluster> found;
  found.fill(kFar);
  for (std::size_t n = 0; n < count; ++n) {
    if (away[n] >= found.back() || n == leave_out) continue;
    std::size_t at = kLargestCluster - 1;
    for (; at > 0 && found[at - 1] > away[n]; --at) found[at] = found[at - 1];
    found[at] = away[n];
  }
  return found;
}

struct Neighbour {
  double away;
  uint32_t index;
};

bool nearer(const Neighbour& one, const Neighbour& other) {
  return one.away != other.away ? one.away < other.away : one.index < other.index;
}

// The nearest of each point, as far as they lie within reach.
class Neighbourhoods {
 public:
  Neighbourhoods(const Cloud& cloud, std::size_t most, double reach)
      : cloud_(cloud), begin_(cloud.count), end_(cloud.count), last_(cloud.count, {kFar, 0}) {
    const CellTable cells(cloud.points_xyz, cloud.count,
                          std::max(reach, kSmallestCell) * kRounding);
    for (const CellTable::Slot& cell : cells.slots()) {
      if (cell.begin == cell.end) continue;
      gather(cells, cell);
      for (int32_t place = cell.begin; place < cell.end; ++place) {
        keep_nearest(uint32_t(cells.order()[std::size_t(place)]), most, reach);
      }
    }
  }

  // Ascending in their indices.
  const Neighbour* begin(std::size_t point) const { return near_.data() + begin_[point]; }
  const Neighbour* end(std::size_t point) const { return near_.data() + end_[point]; }

  // Whether all that lie within reach of a point are kept.
  bool complete(std::size_t point) const { return last_[point].away == kFar; }

  // Whether another point within reach is kept.
  bool has(std::size_t point, const Neighbour& other) const { return !nearer(last_[point], other); }

 private:
  // All points of a cell and those about it.
  void gather(const CellTable& cells, const CellTable::Slot& cell) {
    const double* p = cloud_.points_xyz + 3 * std::size_t(cells.order()[std::size_t(cell.begin)]);
    const int64_t at[3] = {cells.cell_of(p[0]), cells.cell_of(p[1]), cells.cell_of(p[2])};
    indices_.clear(), candidates_.clear();
    for (int64_t i = at[0] - 1; i <= at[0] + 1; ++i) {
      for (int64_t j = at[1] - 1; j <= at[1] + 1; ++j) {
        for (int64_t k = at[2] - 1; k <= at[2] + 1; ++k) {
          const CellTable::Slot* slot = cells.find(i, j, k);
          if (slot == nullptr) continue;
          for (int32_t place = slot->begin; place < slot->end; ++place) {
            const auto index = std::size_t(cells.order()[std::size_t(place)]);
            indices_.push_back(uint32_t(index));
            candidates_.add(cloud_.points_xyz + 3 * index);
          }
        }
      }
    }
  }

  void keep_nearest(uint32_t point, std::size_t most, double reach) {
    const double* away = candidates_.distances_from(cloud_.points_xyz + 3 * std::size_t(point));
    begin_[point] = near_.size();
    for (std::size_t n = 0; n < indices_.size(); ++n) {
      if (away[n] <= reach && indices_[n] != point) near_.push_back({away[n], indices_[n]});
    }
    const auto first = near_.begin() + std::ptrdiff_t(begin_[point]);
    if (near_.size() - begin_[point] > most) {
      const auto last = first + std::ptrdiff_t(most) - 1;
      std::nth_element(first, last, near_.end(), nearer);
      last_[point] = *last;
      near_.resize(begin_[point] + most);
    }
    std::sort(first, near_.end(),
              [](const Neighbour& a, const Neighbour& b) { return a.index < b.index; });
    end_[point] = near_.size();
  }

  Cloud cloud_;
  std::vector<Neighbour> near_;
  std::vector<std::size_t> begin_, end_;
  std::vector<Neighbour> last_;  // The farthest one kept where some were left out.
  std::vector<uint32_t> indices_;
  Together candidates_;
};

// Corners in ascending order; the last two are one number, by which faces of one first corner sort.
struct Face {
  uint32_t first;
  uint64_t others;
};

Face ascending(uint32_t a, uint32_t b, uint32_t c) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  return {a, uint64_t(b) << 32 | c};
}

// Two neighbours of a point that lie within reach of each other. The triangle may be found from
// each of its corners; it is taken from the smallest that finds it.
class Wedges {
 public:
  Wedges(const Cloud& cloud, const Neighbourhoods& near, double reach)
      : cloud_(cloud), near_(near), reach_(reach) {}

  // Calls taken(one, other), ascending, for those that are taken from `apex`.
  template <typename Taken>
  void of(uint32_t apex, const Taken& taken) {
    sides_.clear(), ends_.clear();
    for (const Neighbour* n = near_.begin(apex); n != near_.end(apex); ++n) {
      if (n->index < apex && near_.complete(n->index)) continue;  // That one finds them all.
      sides_.push_back(*n);
      ends_.add(cloud_.points_xyz + 3 * std::size_t(n->index));
    }
    for (std::size_t i = 0; i + 1 < sides_.size(); ++i) {
      const Neighbour& one = sides_[i];
      const double* across =
          ends_.distances_from(cloud_.points_xyz + 3 * std::size_t(one.index), i + 1);
      for (std::size_t j = i + 1; j < sides_.size(); ++j) {
        const Neighbour& other = sides_[j];
        const double edge = across[j - i - 1];
        if (edge > reach_ || finds(one, apex, {edge, other.index}) ||
            finds(other, apex, {edge, one.index})) {
          continue;
        }
        taken(one.index, other.index);
      }
    }
  }

 private:
  // Whether a smaller corner than the apex has the other two among its neighbours.
  bool finds(const Neighbour& corner, uint32_t apex, const Neighbour& third) const {
    return corner.index < apex && near_.has(corner.index, {corner.away, apex}) &&
           near_.has(corner.index, third);
  }

  const Cloud& cloud_;
  const Neighbourhoods& near_;
  double reach_;
  std::vector<Neighbour> sides_;
  Together ends_;
};

}  // namespace

double spacing(const Cloud& cloud) {
  const std::size_t step = std::max<std::size_t>(1, cloud.count / kSample);
  std::vector<std::vector<double>> by_rank(std::min(kLargestCluster, cloud.count - 1));
  Together all;
  for (std::size_t n = 0; n < cloud.count; ++n) all.add(cloud.points_xyz + 3 * n);
  for (std::size_t n = 0; n < cloud.count; n += step) {
    const auto nearest = smallest(all.distances_from(cloud.points_xyz + 3 * n), cloud.count, n);
    for (std::size_t rank = 0; rank < by_rank.size(); ++rank) {
      by_rank[rank].push_back(nearest[rank]);
    }
  }
  double last = median(by_rank[0]), found = last;
  for (std::size_t rank = 1; rank < by_rank.size(); ++rank) {
    const double here = median(by_rank[rank]);
    if (here > kJump * last) found = here;
    last = here;
  }
  return found;
}

std::vector<int64_t> short_edge_faces(const Cloud& cloud, const NearRules& rules) {
  const double reach = rules.reach * spacing(cloud);
  const Neighbourhoods near(cloud, rules.neighbours, reach);
  Wedges wedges(cloud, near, reach);
  std::vector<Face> found;
  std::vector<std::size_t> end(cloud.count + 1, 0);
  for (uint32_t apex = 0; apex < cloud.count; ++apex) {
    wedges.of(apex, [&](uint32_t one, uint32_t other) {
      found.push_back(ascending(apex, one, other));
      ++end[found.back().first + 1];
    });
  }
  // Sorted by their first corner by counting, then each corner's few.
  for (std::size_t n = 0; n < cloud.count; ++n) end[n + 1] += end[n];
  std::vector<uint64_t> others(found.size());
  for (const Face& face : found) others[end[face.first]++] = face.others;
  std::vector<int64_t> corners(3 * found.size());
  auto next = corners.begin();
  std::size_t begin = 0;
  for (std::size_t n = 0; n < cloud.count; begin = end[n++]) {
    std::sort(others.begin() + std::ptrdiff_t(begin), others.begin() + std::ptrdiff_t(end[n]));
    for (std::size_t f = begin; f < end[n]; ++f) {
      *next++ = int64_t(n), *next++ = int64_t(others[f] >> 32);
      *next++ = int64_t(others[f] & 0xFFFFFFFFu);
    }
  }
  return corners;
}

}  // namespace circumspect
