// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Runs work over ordered slabs. Each element writes its own output and reads no other's, so bytes do not depend on the threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <exception>
#include <thread>
#include <vector>

namespace hullrecon {

inline int thread_count(int asked) {
  return asked > 0 ? asked : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// Calls work(begin, end) over [0, count) cut into at most `threads` slabs of at least `grain`. The first exception (by slab)
// is rethrown.
template <class Work>
void for_slabs(int64_t count, int threads, const Work& work, int64_t grain = 256) {
  const int64_t slabs = std::clamp<int64_t>(count / grain, 1, thread_count(threads));
  if (slabs == 1) return work(int64_t{0}, count);
  std::vector<std::exception_ptr> failure(slabs);
  std::vector<std::thread> workers;
  for (int64_t s = 0; s < slabs; ++s) {
    workers.emplace_back([&, s] {
      try {
        work(s * count / slabs, (s + 1) * count / slabs);
      } catch (...) {
        failure[s] = std::current_exception();
      }
    });
  }
  for (auto& member : workers) member.join();
  for (auto& error : failure) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace hullrecon
