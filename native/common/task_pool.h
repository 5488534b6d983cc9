// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Runs tasks that make and wait for tasks of their own. Plain threads that live as long as the pool,
// not OpenMP's, which a process forked from ours could not use again.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace hullrecon {

class TaskPool {
 public:
  // With the calling thread, so many.
  explicit TaskPool(int threads) {
    for (int k = 1; k < threads; ++k) {
      members_.emplace_back([this] { work(nullptr, [this] { return ended_; }); });
    }
  }
  ~TaskPool() {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    changed_.notify_all();
    for (auto& member : members_) member.join();
  }
  TaskPool(const TaskPool&) = delete;
  TaskPool& operator=(const TaskPool&) = delete;

  // Tasks that are waited for together. They must not throw.
  class Group {
    friend class TaskPool;
    int open_ = 0;
  };
  void add(Group& group, std::function<void()> task) {
    {
      const std::lock_guard lock(mutex_);
      ++group.open_;
      tasks_.emplace_back(&group, std::move(task));
    }
    changed_.notify_one();
  }
  // Works, on whatever is to be done, until the group's tasks are.
  void finish(const Group& group) {
    work(&group, [&] { return group.open_ == 0; });
  }

 private:
  // own: the group waited for, whose tasks go first; else those of the newest. A group's own go in the order of add(), so that
  // what is begun is ended before more is begun: results that wait for it take memory.
  template <class Done>
  void work(const Group* own, const Done& done) {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [&] { return done() || !tasks_.empty(); });
      if (done()) return;
      auto at = std::find_if(tasks_.begin(), tasks_.end(), [&](const auto& t) { return t.first == own; });
      if (at == tasks_.end())
        at = std::find_if(tasks_.begin(), tasks_.end(), [&](const auto& t) { return t.first == tasks_.back().first; });
      auto [group, task] = std::move(*at);
      tasks_.erase(at);
      lock.unlock();
      task();
      lock.lock();
      if (--group->open_ == 0) changed_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::pair<Group*, std::function<void()>>> tasks_;
  bool ended_ = false;
  std::vector<std::thread> members_;  // last: they use all of the above
};

}  // namespace hullrecon
