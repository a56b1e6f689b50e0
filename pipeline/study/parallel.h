// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#ifdef __SANITIZE_THREAD__
#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>
#else
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#endif
#include <tbb/task_arena.h>

namespace trilat {

// Calls body(i) for every i < count on the threads of the current arena, `grain` neighbours at a time; the
// first exception of a body is passed on. The thread sanitizer cannot see into the library that hands out the
// work and would report its every hand-over, so under it plain threads do the same, and what is reported is
// ours; an arena of one thread stays one.
template <class Body>
void parallel_for_index(std::size_t count, std::size_t grain, const Body& body) {
#ifdef __SANITIZE_THREAD__
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    try {
      for (std::size_t first; (first = next.fetch_add(grain)) < count;)
        for (std::size_t i = first; i < std::min(count, first + grain); ++i) body(i);
    } catch (...) {
      const std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::current_exception();
      next = count;
    }
  };
  std::vector<std::thread> threads;
  if (tbb::this_task_arena::max_concurrency() > 1)
    for (int t = 0; t < 3; ++t) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
#else
  // isolated: a thread that waits for an inner loop does not start on another take meanwhile
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, grain),
        [&](const tbb::blocked_range<std::size_t>& range) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
        },
        tbb::simple_partitioner());
  });
#endif
}

}  // namespace trilat
