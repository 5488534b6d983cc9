// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Vectors whose contents are kept in other memory (common/page_file.h) while nothing uses them.
#pragma once

#include <Eigen/Core>
#include <cstring>
#include <memory>
#include <memory_resource>
#include <vector>

namespace hullrecon {

class Shelf {
 public:
  // pages: null: the vectors stay where they are.
  explicit Shelf(std::pmr::memory_resource* pages) : pages_(pages) {}

  // Numbers without pointers into themselves. The vectors live as long as the shelf is used.
  template <class... Vectors>
  void add(Vectors&... vectors) {
    (entries_.push_back(std::make_unique<Entry<Vectors>>(vectors)), ...);
  }

  void put() {  // the vectors are empty then
    if (!pages_ || is_put_) return;
    for (auto& entry : entries_) entry->put(*pages_);
    is_put_ = true;
  }
  void take() {  // as they were
    if (!is_put_) return;
    for (auto& entry : entries_) entry->take();
    is_put_ = false;
  }

 private:
  struct Stored {
    virtual ~Stored() = default;
    virtual void put(std::pmr::memory_resource& pages) = 0;
    virtual void take() = 0;
  };

  template <class T>
  static void resize(std::vector<T>& vector, Eigen::Index size) {
    size == 0 ? std::vector<T>().swap(vector) : vector.resize(static_cast<size_t>(size));
  }
  template <class T, int Rows>
  static void resize(Eigen::Matrix<T, Rows, Eigen::Dynamic>& matrix, Eigen::Index size) {
    matrix.resize(Rows, size / Rows);
  }
  template <class T>
  static void resize(Eigen::Matrix<T, Eigen::Dynamic, 1>& vector, Eigen::Index size) {
    vector.resize(size);
  }

  template <class Vector>
  class Entry final : public Stored {
   public:
    explicit Entry(Vector& vector) : vector_(vector) {}
    void put(std::pmr::memory_resource& pages) override {
      size_ = vector_.size();
      const size_t bytes = static_cast<size_t>(size_) * sizeof(*vector_.data());
      if (bytes > room_) place_ = pages.allocate(room_ = bytes, alignof(std::max_align_t));
      if (bytes > 0) std::memcpy(place_, vector_.data(), bytes);
      resize(vector_, 0);
    }
    void take() override {
      resize(vector_, static_cast<Eigen::Index>(size_));
      const size_t bytes = static_cast<size_t>(size_) * sizeof(*vector_.data());
      if (bytes > 0) std::memcpy(static_cast<void*>(vector_.data()), place_, bytes);
    }

   private:
    Vector& vector_;
    decltype(std::declval<Vector>().size()) size_ = 0;
    size_t room_ = 0;  // bytes
    void* place_ = nullptr;
  };

  std::pmr::memory_resource* pages_;
  std::vector<std::unique_ptr<Stored>> entries_;
  bool is_put_ = false;
};

}  // namespace hullrecon
