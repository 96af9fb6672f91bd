// The union of two sets of rays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

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

// Appends the rows of `all` that are not in `known`, both ascending and distinct. Returns false if
// `all` lacks one of `known`.
bool added_keys(const int64_t* known, std::size_t known_count, const int64_t* all,
                std::size_t all_count, std::vector<int64_t>& rows);

}  // namespace circumspect
