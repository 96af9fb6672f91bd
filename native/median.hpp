// The median as NumPy has it: the mean of the two in the middle where their number is even.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace circumspect {

// Of at least one value; their order changes.
inline double median(std::vector<double>& values) {
  const auto half = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), half, values.end());
  if (values.size() % 2 == 1) return *half;
  return 0.5 * (*half + *std::max_element(values.begin(), half));
}

}  // namespace circumspect
