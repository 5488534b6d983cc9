// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <numeric>
#include <stdexcept>

#include "common/blas_guard.h"
#include "common/parallel.h"
#include "common/task_pool.h"

#include "expect.h"

using namespace hullrecon;

TEST_CASE("slabs cover every element once, whatever threads and grain") {
  for (int64_t count : {0, 1, 5, 255, 256, 1000, 4097}) {
    for (int threads : {1, 2, 3, 7}) {
      for (int64_t grain : {1, 16, 256}) {
        std::vector<int> seen(count, 0);
        for_slabs(
            count, threads,
            [&](int64_t begin, int64_t end) {
              for (int64_t i = begin; i < end; ++i) ++seen[i];
            },
            grain);
        CHECK(std::accumulate(seen.begin(), seen.end(), int64_t{0}) == count);
        CHECK(std::count(seen.begin(), seen.end(), 1) == count);
      }
    }
  }
}

TEST_CASE("no slab is smaller than the grain, and there are no more than threads") {
  std::atomic<int> slabs = 0;
  std::atomic<int64_t> smallest = 1 << 30;
  for_slabs(
      1000, 8,
      [&](int64_t begin, int64_t end) {
        ++slabs;
        int64_t known = smallest;
        while (end - begin < known && !smallest.compare_exchange_weak(known, end - begin)) {
        }
      },
      300);
  CHECK(slabs == 3);
  CHECK(smallest >= 300);
}

TEST_CASE("of several failing slabs the first is reported") {
  for (int threads : {1, 4}) {
    try {
      for_slabs(4000, threads, [](int64_t begin, int64_t) { throw std::out_of_range(std::to_string(begin)); }, 1000);
      CHECK(false);
    } catch (const std::out_of_range& error) {
      CHECK(std::string(error.what()) == "0");
    }
  }
}

TEST_CASE("asking for no threads means all, for some that many") {
  CHECK(thread_count(3) == 3);
  CHECK(thread_count(0) >= 1);
}

TEST_CASE("tasks that wait for tasks of their own all run, on one thread and on several") {
  for (int threads : {1, 2, 4}) {
    TaskPool pool(threads);
    std::atomic<int> leaves = 0;
    const std::function<void(int)> grow = [&](int depth) {
      if (depth == 0) return void(++leaves);
      TaskPool::Group children;
      for (int k = 0; k < 3; ++k) pool.add(children, [&, depth] { grow(depth - 1); });
      pool.finish(children);
    };
    for (int round = 0; round < 20; ++round) {
      leaves = 0;
      grow(4);
      CHECK(leaves == 81);
    }
  }
}

TEST_CASE("a group is finished when its tasks are, though others are open") {
  TaskPool pool(1);
  TaskPool::Group one, other;
  int done_one = 0, done_other = 0;
  for (int k = 0; k < 5; ++k) pool.add(one, [&] { ++done_one; }), pool.add(other, [&] { ++done_other; });
  pool.finish(one);
  CHECK(done_one == 5);
  pool.finish(other);
  CHECK(done_other == 5);
  pool.finish(TaskPool::Group());  // of nothing
}

TEST_CASE("the guard keeps BLAS and OpenMP on one thread and gives back what was set") {
  openblas_set_num_threads(2);
  omp_set_max_active_levels(3);
  const int threads = openblas_get_num_threads();
  {
    const BlasGuard guard;
    CHECK(openblas_get_num_threads() == 1);
    CHECK(omp_get_max_active_levels() == 0);
    {
      const BlasGuard inner;
      CHECK(openblas_get_num_threads() == 1);
    }
    CHECK(openblas_get_num_threads() == 1);
  }
  CHECK(openblas_get_num_threads() == threads);
  CHECK(omp_get_max_active_levels() == 3);
  openblas_set_num_threads(1);
}
