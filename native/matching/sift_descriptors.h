// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// SIFT descriptors of keypoints that are known [Lowe2004 6], as OpenCV defines them.
#pragma once

#include <cstdint>
#include <span>

namespace hullrecon {

constexpr int kDescriptor = 128;  // 4 x 4 cells of 8 orientations
constexpr int kLeastWidth = 10;   // px of a level

// A smoothed image of the scale space, row by row.
struct ScaleLevel {
  const float* pixel;
  int64_t height, width;
};

// Where a keypoint lies in its level.
struct LevelKeypoint {
  double u, v;       // px, the first pixel's centre is (0, 0)
  double sigma;      // px, its scale
  double angle_rad;  // of its gradient, from u towards -v
  int64_t level;     // its number
};

// Describes keypoints, each within its level: 128 bytes, of length 512 but for rounding. The border's pixels have no gradient.
void describe_keypoints(std::span<const ScaleLevel> levels, std::span<const LevelKeypoint> keypoints, uint8_t* descriptor);

}  // namespace hullrecon
