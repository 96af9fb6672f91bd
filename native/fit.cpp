#include "fit.hpp"

#include <algorithm>
#include <cmath>

#include "block.hpp"
#include "multiversion.hpp"

namespace circumspect {
namespace {

using Axes = std::array<double, 3>;

constexpr std::size_t kRun = 128, kLanes = 8;

// Every place of a run has bounds of its own, so that loops become vector code.
struct Places {
  alignas(64) double low[3][kRun], high[3][kRun];
};

// Weighted coordinates of a run, relative to the first point of all; null weights are `alike`.
CIRCUMSPECT_MULTIVERSION
void weigh(const double* __restrict rows, const double* __restrict weights, double alike,
           const Axes& first, std::size_t count, Places& __restrict places,
           double (*__restrict weighted)[kRun]) {
  for (std::size_t a = 0; a < 3; ++a) {
    double* __restrict low = places.low[a];
    double* __restrict high = places.high[a];
    double* __restrict out = weighted[a];
    const double begin = first[a];
    for (std::size_t n = 0; n < count; ++n) {
      const double value = rows[3 * n + a];
      low[n] = value < low[n] ? value : low[n];
      high[n] = value > high[n] ? value : high[n];
      out[n] = value - begin;
    }
    if (weights == nullptr) {
      for (std::size_t n = 0; n < count; ++n) out[n] *= alike;
    } else {
      for (std::size_t n = 0; n < count; ++n) out[n] *= weights[n];
    }
  }
}

// Eight sums at once, then those of pairs; in this order NumPy adds as well.
CIRCUMSPECT_MULTIVERSION
double sum_of_run(const double* __restrict values, std::size_t count) {
  if (count < kLanes) {
    double sum = 0.0;
    for (std::size_t n = 0; n < count; ++n) sum += values[n];
    return sum;
  }
  double sums[kLanes];
  for (std::size_t lane = 0; lane < kLanes; ++lane) sums[lane] = values[lane];
  std::size_t n = kLanes;
  for (; n + kLanes <= count; n += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) sums[lane] += values[n + lane];
  }
  double sum =
      ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
  for (; n < count; ++n) sum += values[n];
  return sum;
}

class PairwiseSum {
 public:
  PairwiseSum(const double* points_xyz, const double* weights, double alike)
      : rows_(points_xyz), weights_(weights), alike_(alike) {
    std::copy_n(points_xyz, 3, first_.begin());
    for (std::size_t a = 0; a < 3; ++a) {
      std::fill_n(places_.low[a], kRun, first_[a]);
      std::fill_n(places_.high[a], kRun, first_[a]);
    }
  }

  // Of rows from `begin` on.
  Axes of(std::size_t begin, std::size_t count) {
    Axes sum;
    if (count <= kRun) {
      const double* weights = weights_ == nullptr ? nullptr : weights_ + begin;
      weigh(rows_ + 3 * begin, weights, alike_, first_, count, places_, weighted_);
      for (std::size_t a = 0; a < 3; ++a) sum[a] = sum_of_run(weighted_[a], count);
      return sum;
    }
    const std::size_t half = count / 2 - count / 2 % kLanes;
    const Axes one = of(begin, half), other = of(begin + half, count - half);
    for (std::size_t a = 0; a < 3; ++a) sum[a] = one[a] + other[a];
    return sum;
  }

  const Axes& first() const { return first_; }
  const Places& places() const { return places_; }

 private:
  const double *rows_, *weights_;
  double alike_;
  Axes first_;
  Places places_;
  alignas(64) double weighted_[3][kRun];
};

struct Farthest {
  alignas(64) double radius2[kBlock]{}, x[kBlock]{}, y[kBlock]{}, z[kBlock]{};
};

inline double larger(double a, double b) { return a > b ? a : b; }

CIRCUMSPECT_MULTIVERSION
void extend(const double* __restrict rows, const Axes& centre, double cosine, double sine,
            int count, Farthest& __restrict farthest) {
  const double cx = centre[0], cy = centre[1], cz = centre[2];
  for (int n = 0; n < count; ++n) {
    const double x = rows[3 * n] - cx, y = rows[3 * n + 1] - cy, z = rows[3 * n + 2] - cz;
    farthest.radius2[n] = larger(x * x + y * y, farthest.radius2[n]);
    farthest.x[n] = larger(std::fabs(cosine * x + sine * y), farthest.x[n]);
    farthest.y[n] = larger(std::fabs(cosine * y - sine * x), farthest.y[n]);
    farthest.z[n] = larger(std::fabs(z), farthest.z[n]);
  }
}

double largest(const double* values) { return *std::max_element(values, values + kBlock); }

}  // namespace

WeightedCentre weighted_centre(const double* points_xyz, const double* weights, std::size_t count) {
  PairwiseSum pairwise(points_xyz, weights, 1.0 / double(count));
  const Axes sum = pairwise.of(0, count);
  const Places& places = pairwise.places();
  WeightedCentre found;
  for (std::size_t a = 0; a < 3; ++a) {
    found.low[a] = *std::min_element(places.low[a], places.low[a] + kRun);
    found.high[a] = *std::max_element(places.high[a], places.high[a] + kRun);
    found.centre[a] = std::clamp(pairwise.first()[a] + sum[a], found.low[a], found.high[a]);
  }
  return found;
}

Reach reach(const double* points_xyz, std::size_t count, const Axes& centre, double cosine,
            double sine) {
  Farthest farthest;
  for (std::size_t at = 0; at < count; at += kBlock) {
    const int here = int(std::min<std::size_t>(kBlock, count - at));
    extend(points_xyz + 3 * at, centre, cosine, sine, here, farthest);
  }
  return {std::sqrt(largest(farthest.radius2)), largest(farthest.x), largest(farthest.y),
          largest(farthest.z)};
}

}  // namespace circumspect
