// The union of two sets of rays.
#pragma once

#include <cstddef>
#include <cstdint>

namespace circumspect {

// Rays with ascending and distinct keys.
struct Rays {
  const int64_t* keys;
  const float *origins_xyz, *ends_xyz;
  const bool* on_object;
  std::size_t count;
};

// Arrays for the union, with room for the rays of both sets.
struct RayOutput {
  int64_t* keys;
  float *origins_xyz, *ends_xyz;
  bool* on_object;
};

// Writes the union, for equal keys the ray of the first set. Returns its size.
std::size_t merged_rays(const Rays& one, const Rays& other, const RayOutput& out);

}  // namespace circumspect
