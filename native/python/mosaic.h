// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The part of the module that blends views.
#pragma once

#include <pybind11/pybind11.h>

namespace hullrecon {

void bind_mosaic(pybind11::module_& m);

}  // namespace hullrecon
