// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "common/page_file.h"

#include <algorithm>
#include <fstream>
#include <numeric>
#include <string>

#include "common/errors.h"
#include "expect.h"

using namespace hullrecon;

namespace {

// Of files in this process, kB.
int64_t resident_kb() {
  std::ifstream status("/proc/self/status");
  std::string word;
  int64_t kb = 0, sum = 0;
  while (status >> word) {
    if (word == "RssFile:" || word == "RssShmem:") status >> kb, sum += kb;
  }
  return sum;
}

TEST_CASE("pages at rest leave the process and come back as they were") {
  PageFile pages("/tmp");
  std::pmr::vector<int64_t> numbers(size_t{1} << 21, 0, &pages), small(3, 7, &pages);  // 16 MiB
  std::iota(numbers.begin(), numbers.end(), 5);
  const int64_t before = resident_kb();
  pages.rest();
  CHECK(resident_kb() < before - 15000);
  CHECK(numbers.front() == 5);
  CHECK(numbers.back() == 4 + (int64_t{1} << 21));
  CHECK(small == std::pmr::vector<int64_t>(3, 7));
}

TEST_CASE("whole pages of a stretch leave the process, those around it stay") {
  PageFile pages("/tmp");
  std::pmr::vector<int64_t> numbers(size_t{1} << 21, 3, &pages);  // 16 MiB
  const int64_t before = resident_kb();
  pages.rest(&numbers[1 << 19], &numbers[3 << 19]);
  CHECK(resident_kb() < before - 7000);
  CHECK(resident_kb() > before - 9000);
  pages.rest(&numbers[1], &numbers[2]);
  CHECK(numbers == std::pmr::vector<int64_t>(size_t{1} << 21, 3));
}

TEST_CASE("what is allocated does not overlap, and is aligned") {
  PageFile pages("/tmp");
  auto* const one = static_cast<char*>(pages.allocate(3, 1));
  auto* const two = static_cast<char*>(pages.allocate(8, 8));
  auto* const large = static_cast<char*>(pages.allocate(5 << 20, 16));
  CHECK(two >= one + 3);
  CHECK(reinterpret_cast<uintptr_t>(two) % 8 == 0);
  CHECK(reinterpret_cast<uintptr_t>(large) % 16 == 0);
  std::fill_n(large, 5 << 20, 'x'), std::fill_n(two, 8, 'y'), std::fill_n(one, 3, 'z');
  CHECK(large[0] == 'x');
  CHECK(two[0] == 'y');
  CHECK(one[2] == 'z');
}

TEST_CASE("a folder that is not there is named") {
  CHECK_THROWS_AS(PageFile("/no/such/folder"), DiskError);
}

}  // namespace
