// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Exceptions of the native code; python/convert.h maps each to its twin in hullrecon.errors. Nothing is printed, nothing
// aborts.
#pragma once

#include <stdexcept>
#include <string>

namespace hullrecon {

struct Error : std::runtime_error {
  Error(std::string what, std::string where, std::string remedy)
      : std::runtime_error(what), where(std::move(where)), remedy(std::move(remedy)) {}
  std::string where, remedy;
};

struct InputError : Error {  // a table that cannot be used; where = its name
  using Error::Error;
};
struct UsageError : Error {  // an option that cannot be meant; where = its name
  using Error::Error;
};
struct StageError : Error {  // sound input without a result: no convergence, an unknown that nothing determines
  using Error::Error;
};
struct DiskError : Error {  // a file that cannot be made or grown; where = its folder
  DiskError(int number, std::string what, std::string where) : Error(std::move(what), std::move(where), ""), number(number) {}
  int number;  // errno
};
struct Interrupted : std::exception {};  // Ctrl-C between two iterations

}  // namespace hullrecon
