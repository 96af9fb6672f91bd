// Splits a range over threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <system_error>
#include <thread>
#include <vector>

namespace circumspect {

// Calls work(begin, end) on consecutive parts of [0, count); at most one part a thread, and
// none smaller than `grain`. Where no thread can be started, the caller does the work.
template <typename Work>
void parallel_for(std::size_t count, std::size_t threads, std::size_t grain, const Work& work) {
  const std::size_t wanted = std::min(threads, count / std::max<std::size_t>(grain, 1));
  const std::size_t parts = std::max<std::size_t>(wanted, 1);
  const auto begin = [&](std::size_t part) { return count / parts * part + std::min(part, count % parts); };
  std::vector<std::thread> helpers;
  helpers.reserve(parts);
  std::size_t started = 1;
  try {
    for (; started < parts; ++started) {
      helpers.emplace_back([&work, from = begin(started), to = begin(started + 1)] { work(from, to); });
    }
  } catch (const std::system_error&) {
    // Too many threads already: the rest is done below.
  }
  work(begin(0), begin(1));
  if (started < parts) work(begin(started), count);
  for (std::thread& helper : helpers) helper.join();
}

}  // namespace circumspect
