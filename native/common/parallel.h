// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Runs work over ordered slabs. Each element writes its own output and reads no other's, so bytes do not depend on the threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <thread>
#include <vector>

namespace hullrecon {

inline int thread_count(int asked) {
  return asked > 0 ? asked : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// Slabs a thread: the cost of elements varies (poses that see much, kinds of factors), and a thread that is done takes the
// next.
constexpr int64_t kSlabsOfThread = 8;

// Calls work(begin, end) over [0, count) cut into slabs of at least `grain`, by `threads` threads, this one among them. The
// first exception (by slab) is rethrown.
template <class Work>
void for_slabs(int64_t count, int threads, const Work& work, int64_t grain = 256) {
  const int64_t most = thread_count(threads),
                slabs = std::clamp<int64_t>(count / grain, 1, most > 1 ? most * kSlabsOfThread : 1);
  if (slabs == 1) return work(int64_t{0}, count);
  std::vector<std::exception_ptr> failure(slabs);
  std::atomic<int64_t> next = 0;
  const auto take_slabs = [&] {
    for (int64_t s = next++; s < slabs; s = next++) {
      try {
        work(s * count / slabs, (s + 1) * count / slabs);
      } catch (...) {
        failure[s] = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> others;
    for (int64_t k = 1; k < std::min(most, slabs); ++k) others.emplace_back(take_slabs);
    take_slabs();
  }
  for (auto& error : failure) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace hullrecon
