// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "common/page_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "common/errors.h"

namespace hullrecon {
namespace {

const auto kPage = static_cast<size_t>(sysconf(_SC_PAGESIZE));
constexpr size_t kLeast = size_t{1} << 20;  // of a region

[[noreturn]] void fail(int error, const std::string& folder) {
  throw DiskError(error, std::strerror(error), folder);
}

}  // namespace

PageFile::PageFile(std::string folder) : folder_(std::move(folder)) {
  std::string name = folder_ + "/hullrecon-part-XXXXXX";
  file_ = mkostemp(name.data(), O_CLOEXEC);
  if (file_ < 0) fail(errno, folder_);
  unlink(name.c_str());
}

PageFile::~PageFile() {
  for (const Region& region : regions_) munmap(region.begin, region.size);
  close(file_);
}

void PageFile::rest() const {
  // What was written stays in the file: the mapping is shared.
  for (const Region& region : regions_) madvise(region.begin, region.size, MADV_DONTNEED);
}

void PageFile::rest(const void* begin, const void* end) const {
  const size_t first = (reinterpret_cast<uintptr_t>(begin) + kPage - 1) / kPage,
               last = reinterpret_cast<uintptr_t>(end) / kPage;
  if (first < last) madvise(reinterpret_cast<void*>(first * kPage), (last - first) * kPage, MADV_DONTNEED);
}

void* PageFile::do_allocate(size_t bytes, size_t alignment) {
  const auto aligned = [&](size_t used) { return (used + alignment - 1) / alignment * alignment; };
  if (regions_.empty() || aligned(regions_.back().used) + bytes > regions_.back().size) grow(bytes);
  Region& region = regions_.back();
  const size_t first = aligned(region.used);
  region.used = first + bytes;
  return region.begin + first;
}

void PageFile::grow(size_t bytes) {
  const size_t size = (std::max(bytes, kLeast) + kPage - 1) / kPage * kPage;
  // The disk's space is taken here: where there is none, writing to a page would end the process.
  if (const int error = posix_fallocate(file_, static_cast<off_t>(size_), static_cast<off_t>(size))) fail(error, folder_);
  void* const at = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file_, static_cast<off_t>(size_));
  if (at == MAP_FAILED) fail(errno, folder_);
  regions_.push_back({static_cast<char*>(at), size, 0});
  size_ += size;
}

}  // namespace hullrecon
