// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/drawing.h"

#include <algorithm>
#include <cmath>

namespace hullrecon {
namespace {

constexpr double kSlack = 1e-9;  // of the triangle's size: a pixel's middle on a shared edge must not slip between two

// First and past the last pixel whose middles lie between, within the picture.
std::array<int64_t, 2> pixels_between(double low, double high, int64_t size) {
  const double last = static_cast<double>(size);
  return {static_cast<int64_t>(std::ceil(std::clamp(low - 0.5, 0.0, last))),
          static_cast<int64_t>(std::floor(std::clamp(high - 0.5, -1.0, last - 1))) + 1};
}

}  // namespace

void draw_triangle(const Canvas& canvas, const std::array<const double*, 3>& corner, const std::array<const float*, 3>& value) {
  const auto [x0, x1, x2] = std::array{corner[0][0], corner[1][0], corner[2][0]};
  const auto [y0, y1, y2] = std::array{corner[0][1], corner[1][1], corner[2][1]};
  const double twice = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0);
  if (!(std::abs(twice) > 0)) return;
  const auto columns = pixels_between(std::min({x0, x1, x2}), std::max({x0, x1, x2}), canvas.width);
  const auto rows = pixels_between(std::min({y0, y1, y2}), std::max({y0, y1, y2}), canvas.height);
  for (int64_t row = rows[0]; row < rows[1]; ++row) {
    const double y = static_cast<double>(row) + 0.5 - y0;
    for (int64_t column = columns[0]; column < columns[1]; ++column) {
      const double x = static_cast<double>(column) + 0.5 - x0;
      const double second = (x * (y2 - y0) - (x2 - x0) * y) / twice, third = ((x1 - x0) * y - x * (y1 - y0)) / twice;
      const double first = 1 - second - third;
      if (std::min({first, second, third}) < -kSlack) continue;
      float* pixel = canvas.value + (row * canvas.width + column) * canvas.channels;
      for (int64_t k = 0; k < canvas.channels; ++k) {
        pixel[k] = static_cast<float>(first * value[0][k] + second * value[1][k] + third * value[2][k]);
      }
    }
  }
}

}  // namespace hullrecon
