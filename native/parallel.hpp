// Splits a range over threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace circumspect {

// Calls work(begin, end) on consecutive parts of [0, count); at most one part a thread, and
// none smaller than `grain`. Where no thread can be started, the caller does the work. An
// exception of any part is thrown again when all are done.
template <typename Work>
void parallel_for(std::size_t count, std::size_t threads, std::size_t grain, const Work& work) {
  const std::size_t wanted = std::min(threads, count / std::max<std::size_t>(grain, 1));
  const std::size_t parts = std::max<std::size_t>(wanted, 1);
  std::vector<std::exception_ptr> faults(parts);
  const auto begin = [&](std::size_t part) {
    return count / parts * part + std::min(part, count % parts);
  };
  const auto run = [&](std::size_t part, std::size_t from, std::size_t to) {
    try {
      work(from, to);
    } catch (...) {
      faults[part] = std::current_exception();
    }
  };
  std::vector<std::thread> helpers;
  helpers.reserve(parts);
  std::size_t started = 1;
  try {
    for (; started < parts; ++started) {
      helpers.emplace_back(run, started, begin(started), begin(started + 1));
    }
  } catch (...) {
    // Too many threads already, or no memory for one: the rest is done below.
  }
  run(0, begin(0), begin(1));
  if (started < parts) run(started, begin(started), count);
  for (std::thread& helper : helpers) helper.join();
  for (const std::exception_ptr& fault : faults) {
    if (fault) std::rethrow_exception(fault);
  }
}

}  // namespace circumspect
