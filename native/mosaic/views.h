// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The operations of a mosaic on every view at every texel: project, rank, blend (docs/methods.md 13).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

namespace hullrecon {

// An image and where it was taken.
struct PlacedImage {
  Eigen::Matrix3d camera_from_frame;
  Eigen::Vector3d center;      // of the camera in the frame
  std::array<double, 9> lens;  // fx fy cx cy k1 k2 p1 p2 k3
  double width, height;        // px
  double widest;               // x / z and y / z beyond which the distortion would fold points back
};

// Projects points (n x 3) to pixels (n x 2), and measures their distance from the middle of the image over half its diagonal,
// NaN where the image does not hold them.
void project_into(const PlacedImage& image, std::span<const double> points, double* pixel, double* ratio);

// Cosines of the incidence of a sensor at points with normals (n x 3).
void incidence(std::span<const double> points, std::span<const double> normals, const Eigen::Vector3d& sensor, double* cosine);

// Puts a view into each texel's list of the best, where it costs less than the last. Of equals the first view comes first.
// Lists of `places` rows of `texels`, the best first.
void insert_view(int32_t view, std::span<const float> cost, int64_t places, int32_t* best_view, float* best_cost);

// A picture's bands, each (height x width x channels), that sum to it: of one channel or three.
struct Bands {
  std::span<const float* const> band;
  int64_t height, width, channels;
};

// Sums over the views blended so far, at every texel.
struct BlendSums {
  float *value, *weight;  // (texels x bands x channels), (texels x bands)
  float* moment;          // (texels x 3): of weight, weight x intensity, weight x intensity squared
  uint8_t* views;         // (texels) how many
};

// Adds a view at some texels (rows): its bands sampled bilinearly at pixels (n x 2), weighted by B_k(ratio) with the steepness
// of each band. Past its border the picture goes on as it ends.
void add_view(const Bands& picture, std::span<const int64_t> rows, std::span<const float> pixel, std::span<const double> ratio,
              std::span<const double> steepness, const BlendSums& sums);

}  // namespace hullrecon
