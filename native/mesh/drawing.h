// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Draws triangles into a picture.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace hullrecon {

// A picture (height x width x channels) that is drawn over.
struct Canvas {
  float* value;
  int64_t height, width, channels;
};

// Draws a triangle, its corners in pixels from the picture's corner, onto the pixels whose middles it holds, its border among
// them. Values are linear between those of the corners (channels each).
void draw_triangle(const Canvas& canvas, const std::array<const double*, 3>& corner, const std::array<const float*, 3>& value);

}  // namespace hullrecon
