// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "mosaic/views.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/wide.h"
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

// Points are projected four at a time.
constexpr size_t kLanes = 4;
using Lanes = double __attribute__((vector_size(8 * kLanes)));
using Flags = int64_t __attribute__((vector_size(8 * kLanes)));  // -1 where something holds

// `project` and the bounds of `project_into` for a whole number of kLanes points.
HULLRECON_WIDE void project_lanes(const PlacedImage& image, const double* points, size_t count, double* pixel, double* ratio) {
  const auto& turn = image.camera_from_frame;
  const auto [fx, fy, cx, cy, k1, k2, p1, p2, k3] = image.lens;
  const double half_diagonal = 0.5 * std::hypot(image.width, image.height);
  for (size_t i = 0; i < count; i += kLanes) {
    const double* at = points + 3 * i;
    const Lanes from_x = Lanes{at[0], at[3], at[6], at[9]} - image.center[0];
    const Lanes from_y = Lanes{at[1], at[4], at[7], at[10]} - image.center[1];
    const Lanes from_z = Lanes{at[2], at[5], at[8], at[11]} - image.center[2];
    const Lanes right = turn(0, 0) * from_x + turn(0, 1) * from_y + turn(0, 2) * from_z;
    const Lanes down = turn(1, 0) * from_x + turn(1, 1) * from_y + turn(1, 2) * from_z;
    const Lanes depth = turn(2, 0) * from_x + turn(2, 1) * from_y + turn(2, 2) * from_z;
    const Lanes x = right / depth, y = down / depth, r2 = x * x + y * y;
    const Lanes radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const Lanes u = fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx;
    const Lanes v = fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy;
    const Flags ahead = depth > kInFront;
    const Lanes widest = image.widest * depth;
    const Flags held = ahead & (right < widest) & (-right < widest) & (down < widest) & (-down < widest) & (u >= 1) &
                       (u <= image.width - 2) & (v >= 1) & (v <= image.height - 2);
    const Lanes off_u = u - (image.width - 1) / 2, off_v = v - (image.height - 1) / 2;
    const Lanes squared = off_u * off_u + off_v * off_v;
    for (size_t k = 0; k < kLanes; ++k) {
      pixel[2 * (i + k)] = ahead[k] ? u[k] : kNaN, pixel[2 * (i + k) + 1] = ahead[k] ? v[k] : kNaN;
      ratio[i + k] = held[k] ? std::sqrt(squared[k]) / half_diagonal : kNaN;
    }
  }
}

}  // namespace

void project_into(const PlacedImage& image, std::span<const double> points, double* pixel, double* ratio) {
  const size_t count = points.size() / 3, whole = count / kLanes * kLanes;
  project_lanes(image, points.data(), whole, pixel, ratio);
  if (whole == count) return;
  // The last few, and in place of those that are missing the first of them.
  std::array<double, 3 * kLanes> last;
  std::array<double, 2 * kLanes> pixel_of_last;
  std::array<double, kLanes> ratio_of_last;
  for (size_t k = 0; k < kLanes; ++k) std::copy_n(&points[3 * (whole + k < count ? whole + k : whole)], 3, &last[3 * k]);
  project_lanes(image, last.data(), kLanes, pixel_of_last.data(), ratio_of_last.data());
  std::copy_n(pixel_of_last.data(), 2 * (count - whole), pixel + 2 * whole);
  std::copy_n(ratio_of_last.data(), count - whole, ratio + whole);
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
