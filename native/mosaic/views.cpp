// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "mosaic/views.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "factors/camera.h"

namespace hullrecon {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Four neighbours of a pixel in a picture (offsets of their first channel) and what each counts.
struct Neighbours {
  std::array<int64_t, 4> at;
  std::array<float, 4> share;

  Neighbours(const float* pixel, const Bands& picture) {
    const float x = inside(pixel[0], picture.width), y = inside(pixel[1], picture.height);
    const auto left = static_cast<int32_t>(x), top = static_cast<int32_t>(y);
    const int64_t right = std::min<int64_t>(left + 1, picture.width - 1), low = std::min<int64_t>(top + 1, picture.height - 1);
    const float to_right = x - static_cast<float>(left), down = y - static_cast<float>(top);
    at = {top * picture.width + left, top * picture.width + right, low * picture.width + left, low * picture.width + right};
    for (int64_t& one : at) one *= picture.channels;
    share = {(1 - down) * (1 - to_right), (1 - down) * to_right, down * (1 - to_right), down * to_right};
  }

  float sample(const float* band) const {
    return band[at[0]] * share[0] + band[at[1]] * share[1] + band[at[2]] * share[2] + band[at[3]] * share[3];
  }

 private:
  static float inside(float place, int64_t size) { return std::max(0.0f, std::min(place, static_cast<float>(size - 1))); }
};

float band_weight(double ratio, double steepness) {
  if (std::isnan(ratio)) return 0;
  const double fall = std::exp(-steepness * ratio);
  return static_cast<float>(fall / (1 + fall * fall));
}

}  // namespace

void project_into(const PlacedImage& image, std::span<const double> points, double* pixel, double* ratio) {
  const double half_diagonal = 0.5 * std::hypot(image.width, image.height);
  const Eigen::Vector2d middle{(image.width - 1) / 2, (image.height - 1) / 2};
  for (size_t i = 0; i < points.size() / 3; ++i) {
    const Eigen::Vector3d inside = image.camera_from_frame * (Eigen::Map<const Eigen::Vector3d>(&points[3 * i]) - image.center);
    Projection seen;
    const bool ahead = project(image.lens.data(), inside, false, seen);
    const double u = ahead ? seen.pixel[0] : kNaN, v = ahead ? seen.pixel[1] : kNaN;
    const bool held = inside.head<2>().cwiseAbs().maxCoeff() < image.widest * inside[2] && u >= 1 && u <= image.width - 2 &&
                      v >= 1 && v <= image.height - 2;
    pixel[2 * i] = u, pixel[2 * i + 1] = v;
    ratio[i] = held ? (seen.pixel - middle).norm() / half_diagonal : kNaN;
  }
}

void incidence(std::span<const double> points, std::span<const double> normals, const Eigen::Vector3d& sensor, double* cosine) {
  for (size_t i = 0; i < points.size() / 3; ++i) {
    const Eigen::Vector3d away = sensor - Eigen::Map<const Eigen::Vector3d>(&points[3 * i]);
    cosine[i] = away.dot(Eigen::Map<const Eigen::Vector3d>(&normals[3 * i])) / away.norm();
  }
}

void insert_view(int32_t view, std::span<const float> cost, int64_t places, int32_t* best_view, float* best_cost) {
  const auto texels = static_cast<int64_t>(cost.size());
  for (int64_t i = 0; i < texels; ++i) {
    float moved_cost = cost[i];
    int32_t moved = view;
    for (int64_t at = i; at < places * texels; at += texels) {
      if (moved_cost < best_cost[at] || (moved_cost == best_cost[at] && moved < best_view[at])) {
        std::swap(moved_cost, best_cost[at]), std::swap(moved, best_view[at]);
      }
    }
  }
}

namespace {

// kChannels: known to the compiler, which unrolls the loop over them.
template <int kChannels>
void add(const Bands& picture, std::span<const int64_t> rows, std::span<const float> pixel, std::span<const double> ratio,
         std::span<const double> steepness, const BlendSums& sums) {
  const auto bands = static_cast<int64_t>(picture.band.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    const Neighbours near(&pixel[2 * i], picture);
    float* value = sums.value + rows[i] * bands * kChannels;
    float* weight = sums.weight + rows[i] * bands;
    float* moment = sums.moment + rows[i] * 3;
    float all = 0, intensity = 0;
    for (int64_t b = 0; b < bands; ++b) {
      const float w = band_weight(ratio[i], steepness[b]);
      for (int c = 0; c < kChannels; ++c) {
        const float sampled = near.sample(picture.band[b] + c);
        value[b * kChannels + c] += w * sampled;
        intensity += sampled;
      }
      weight[b] += w;
      all += w;
    }
    const float mean = all / static_cast<float>(bands);
    intensity /= kChannels;
    moment[0] += mean, moment[1] += mean * intensity, moment[2] += mean * (intensity * intensity);
    sums.views[rows[i]] += 1;
  }
}

}  // namespace

void add_view(const Bands& picture, std::span<const int64_t> rows, std::span<const float> pixel, std::span<const double> ratio,
              std::span<const double> steepness, const BlendSums& sums) {
  const auto of_channels = picture.channels == 1 ? &add<1> : &add<3>;
  of_channels(picture, rows, pixel, ratio, steepness, sums);
}

}  // namespace hullrecon
