// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace hullrecon {

// Returns freed memory to the system. The allocator would keep it between blocks that last: 2.6 of the 3.8 GB that a dive of
// 45,000 stereo pairs took in 64 parts. C libraries other than glibc have no such call.
inline void return_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace hullrecon
