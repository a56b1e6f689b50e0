// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cstddef>

namespace trilat {

// Calls body(i) for every i < count on the threads of the current arena, `grain` neighbours at a time. The fence
// repeats in this program's own code what the library guarantees (all before it happens before the bodies, all bodies
// before its return), so that the thread sanitizer, which cannot see into the library, can tell real races.
template <class Body>
void parallel_for_index(std::size_t count, std::size_t grain, const Body& body) {
  std::atomic<std::size_t> fence{0};
  fence.store(1, std::memory_order_release);
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, count, grain),
      [&](const tbb::blocked_range<std::size_t>& range) {
        fence.fetch_add(1, std::memory_order_acq_rel);
        for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
        fence.fetch_add(1, std::memory_order_acq_rel);
      },
      tbb::simple_partitioner());
  (void)fence.load(std::memory_order_acquire);
}

}  // namespace trilat
