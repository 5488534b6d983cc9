// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Memory that leaves the process while it is not used: pages of a temporary file, which the system may write out. Of many parts
// of a problem only the one at work is then in memory.
#pragma once

#include <memory_resource>
#include <string>
#include <vector>

namespace hullrecon {

class PageFile final : public std::pmr::memory_resource {
 public:
  // A file without a name in this folder. Throws DiskError where it cannot be made, and from allocations where the disk
  // is full.
  explicit PageFile(std::string folder);
  ~PageFile() override;
  PageFile(const PageFile&) = delete;
  PageFile& operator=(const PageFile&) = delete;

  void rest() const;  // removes all pages from the process. They return unchanged when they are read or written.
  void rest(const void* begin, const void* end) const;  // those alone that lie between
  const std::string& folder() const { return folder_; }

 private:
  struct Region {
    char* begin;
    size_t size, used;
  };
  void* do_allocate(size_t bytes, size_t alignment) override;
  void do_deallocate(void*, size_t, size_t) override {}  // all of it goes at the end
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override { return this == &other; }
  void grow(size_t bytes);

  std::string folder_;
  int file_;
  std::vector<Region> regions_;
  size_t size_ = 0;  // of the file
};

}  // namespace hullrecon
