// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Every residual of the adjustment, raw: whitening and robust loss are applied in cost.h and mixture.h, once for all.
#pragma once

#include "hullrecon/factors_camera.h"
#include "hullrecon/factors_hull.h"
#include "hullrecon/factors_navigation.h"
