// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Functions that are compiled for processors with AVX2 and fused products, too, besides those that every x86-64 can run. Which
// one runs is decided when the module is loaded: bytes are the same for one machine.
#pragma once

#define HULLRECON_WIDE __attribute__((target_clones("arch=x86-64-v3", "default")))

// And with them all that they call, as far as it is inlined.
#define HULLRECON_WIDE_ALL __attribute__((flatten, target_clones("arch=x86-64-v3", "default")))
