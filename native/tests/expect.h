// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// doctest after Ceres: glog, which Ceres includes, takes the name CHECK and aborts where a test should fail. Include this last.
#pragma once

#include <ceres/rotation.h>
#undef CHECK
#include <doctest/doctest.h>
#undef CHECK
#define CHECK DOCTEST_CHECK
