// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Includes every residual of the adjustment, raw: whitening and robust loss are applied in whitening.h and mixture.h, once for
// all.
#pragma once

#include "factors/hull_residuals.h"
#include "factors/image_residuals.h"
#include "factors/link_residuals.h"
#include "factors/navigation_residuals.h"
#include "factors/plane_residuals.h"
