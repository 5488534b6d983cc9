// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// CHOLMOD opens OpenMP teams inside one another and OpenBLAS threads of its own; on cores that are not free they spin (one
// factorisation took 9 to 24 s instead of 0.5). For the life of this object both stay on the calling thread.
#pragma once

#include <omp.h>

extern "C" {
void openblas_set_num_threads(int);
int openblas_get_num_threads(void);
}

namespace hullrecon {

class BlasGuard {
 public:
  BlasGuard() : levels_(omp_get_max_active_levels()), threads_(openblas_get_num_threads()) {
    omp_set_max_active_levels(0);
    openblas_set_num_threads(1);
  }
  ~BlasGuard() {
    omp_set_max_active_levels(levels_);
    openblas_set_num_threads(threads_);
  }
  BlasGuard(const BlasGuard&) = delete;
  BlasGuard& operator=(const BlasGuard&) = delete;

 private:
  int levels_, threads_;
};

}  // namespace hullrecon
