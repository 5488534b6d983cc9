// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "matching/sift_descriptors.h"

#include <xmmintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include "common/wide.h"

namespace hullrecon {
namespace {

constexpr int kCells = 4, kOrientations = 8;
constexpr int kWide = kCells + 2;    // with a rim, into which samples beyond the outermost centres spread
constexpr double kCellSigmas = 3.0;  // side of a cell [Lowe2004 6.1]
constexpr float kFlattened = 0.2f;   // largest share of one number in the length [Lowe2004 6.1]
constexpr float kLength = 512.0f;
constexpr float kHalf = 0.5f * (kCells + 1);  // cells from the keypoint to where samples end

// What is done eight numbers at a time is compiled for processors with AVX2, too: it takes a third of the time there.
#define HULLRECON_INLINE inline __attribute__((always_inline))

constexpr int kLanes = 8;
using Lanes = float __attribute__((vector_size(4 * kLanes)));
using Whole = int32_t __attribute__((vector_size(4 * kLanes)));
static_assert(kLanes == kOrientations);  // a cell's are a register, too
using Histogram = std::array<Lanes, kWide * kWide>;

// Samples of one row of a keypoint's square, after room for kLanes.
struct Samples {
  std::vector<float> orientation;               // in bins, 0 to 8
  std::vector<float> upper, lower, left_share;  // weighted magnitudes of both rows of cells, and the left column's share
  std::vector<int32_t> cell;                    // the upper left one of four
};

// The square around a keypoint that its cells cover.
struct Square {
  float cosine, sine;  // cells a pixel along u and v
  float angle;         // of the keypoint, in bins
  int64_t u, v;        // its middle
};

HULLRECON_INLINE void load(Lanes& lanes, const float* from) {
  std::memcpy(&lanes, from, sizeof lanes);
}

HULLRECON_INLINE void root(Lanes& squares) {
  float* at = reinterpret_cast<float*>(&squares);
  for (int k = 0; k < kLanes; k += 4) _mm_storeu_ps(at + k, _mm_sqrt_ps(_mm_loadu_ps(at + k)));
}

// Orientations of gradients in bins, 0 to 8, to 1e-4 rad.
HULLRECON_INLINE void find_orientations(const Lanes& x, const Lanes& y, Lanes& bin) {
  constexpr float bins = kOrientations / (2 * std::numbers::pi_v<float>);
  const Lanes ax = x < 0 ? -x : x, ay = y < 0 ? -y : y;
  const Lanes tangent = (ax < ay ? ax : ay) / ((ax < ay ? ay : ax) + 1e-30f);
  const Lanes s = tangent * tangent;
  bin = (((-0.04432655554792128f * s + 0.1555786518463281f) * s - 0.3258083974640975f) * s + 0.9997878412794807f) * bins *
        tangent;
  bin = ay > ax ? kOrientations / 4 - bin : bin;
  bin = x < 0 ? kOrientations / 2 - bin : bin;
  bin = y < 0 ? kOrientations - bin : bin;
}

// Splits places in cells into the cell and the share of the next one. Beyond the rim, the outermost counts: rounding may put a
// sample there.
HULLRECON_INLINE void split(const Lanes& place, Whole& cell, Lanes& share) {
  constexpr float end = kWide - 1.001f;
  const Lanes least = Lanes{}, most = least + end;
  const Lanes positive = place < 0 ? least : place;
  const Lanes inside = positive < end ? positive : most;
  cell = __builtin_convertvector(inside, Whole);
  share = inside - __builtin_convertvector(cell, Lanes);
}

// Samples the gradients of a row, dv below the keypoint, from column `first` to `last` beside it. weight: by pixels off the
// middle.
HULLRECON_WIDE void sample_row(const Square& square, const ScaleLevel& level, int dv, int first, int last, const float* weight,
                               Samples& out) {
  constexpr Lanes number = {0, 1, 2, 3, 4, 5, 6, 7};
  const float* row = level.pixel + (square.v + dv) * level.width + square.u;
  const float column = -dv * square.sine + kHalf, line = dv * square.cosine + kHalf, own = weight[dv];
  const int border = static_cast<int>(level.width - 1 - kLanes - square.u);
  for (int k = first; k <= last; k += kLanes) {
    const int from = std::min(k, border);  // some twice rather than pixels that are not there
    Lanes before, after, above, below, magnitude, orientation, right_share, lower_share;
    load(before, row + from - 1), load(after, row + from + 1);
    load(above, row + from - level.width), load(below, row + from + level.width);
    const Lanes dx = after - before, dy = above - below, du = number + static_cast<float>(from);
    Lanes along;
    load(along, weight + from);
    magnitude = dx * dx + dy * dy;
    root(magnitude);
    magnitude *= along * own;
    find_orientations(dx, dy, orientation);
    orientation -= square.angle;
    Whole cell, above_cells;
    split(du * square.cosine + column, cell, right_share);
    split(du * square.sine + line, above_cells, lower_share);
    cell += kWide * above_cells;
    const Lanes turned = orientation < 0 ? orientation + kOrientations : orientation, lower = magnitude * lower_share;
    const Lanes upper = magnitude - lower, left_share = 1 - right_share;
    const int at = from - first + kLanes;
    std::memcpy(&out.orientation[at], &turned, sizeof turned);
    std::memcpy(&out.upper[at], &upper, sizeof upper);
    std::memcpy(&out.lower[at], &lower, sizeof lower);
    std::memcpy(&out.left_share[at], &left_share, sizeof left_share);
    std::memcpy(&out.cell[at], &cell, sizeof cell);
  }
}

// Spreads samples over two orientations of four cells each. Two histograms, in turns: neighbours mostly meet the same cells,
// and need not wait for each other.
HULLRECON_WIDE void spread(const Samples& samples, int count, std::array<Histogram, 2>& sums) {
  constexpr Lanes lane = {0, 1, 2, 3, 4, 5, 6, 7};
  for (int k = kLanes; k < count + kLanes; ++k) {
    const Lanes off = lane - samples.orientation[k];
    const Lanes ahead = off < 0 ? -off : off;
    const Lanes around = kOrientations - ahead;
    const Lanes near = 1 - (ahead < around ? ahead : around);
    const Lanes share = near > 0 ? near : Lanes{};
    Lanes* cell = sums[k & 1].data() + samples.cell[k];
    const Lanes up = share * samples.upper[k], down = share * samples.lower[k];
    const Lanes left_up = up * samples.left_share[k], left_down = down * samples.left_share[k];
    cell[0] += left_up;
    cell[1] += up - left_up;
    cell[kWide] += left_down;
    cell[kWide + 1] += down - left_down;
  }
}

// The columns of a row that lie within the cells: those where both low < a + b k < high.
void narrow(float slope, float offset, int& first, int& last) {
  if (std::abs(slope) < 1e-6f) {
    if (std::abs(offset) >= kHalf) last = first - 1;
    return;
  }
  const float one = (-kHalf - offset) / slope, other = (kHalf - offset) / slope;
  first = std::max(first, static_cast<int>(std::floor(std::min(one, other))) + 1);
  last = std::min(last, static_cast<int>(std::ceil(std::max(one, other))) - 1);
}

// Limits each number, and scales all to the length.
void normalise(std::array<float, kDescriptor>& sum, uint8_t* descriptor) {
  float squares = 0;
  for (const float value : sum) squares += value * value;
  const float most = kFlattened * std::sqrt(squares);
  squares = 0;
  for (float& value : sum) {
    value = std::min(value, most);
    squares += value * value;
  }
  const float scale = kLength / std::max(std::sqrt(squares), 1e-7f);
  for (int k = 0; k < kDescriptor; ++k) descriptor[k] = static_cast<uint8_t>(std::min(std::nearbyint(sum[k] * scale), 255.0f));
}

class Describer {
 public:
  void describe(const ScaleLevel& level, const LevelKeypoint& keypoint, uint8_t* descriptor) {
    const double side = kCellSigmas * keypoint.sigma;
    const double whole = std::hypot(static_cast<double>(level.width), static_cast<double>(level.height));
    const int radius = static_cast<int>(std::min(std::nearbyint(side * std::numbers::sqrt2 * kHalf), whole));
    prepare(radius, side);
    const Square square{.cosine = static_cast<float>(std::cos(keypoint.angle_rad) / side),
                        .sine = static_cast<float>(std::sin(keypoint.angle_rad) / side),
                        .angle = bins(keypoint.angle_rad),
                        .u = std::llrint(keypoint.u),
                        .v = std::llrint(keypoint.v)};
    for (auto& sums : sums_) sums.fill(Lanes{});
    const auto most = [](int64_t end, int64_t at, int reach) { return static_cast<int>(std::min<int64_t>(end - at, reach)); };
    const int last_row = most(level.height - 2, square.v, radius);
    for (int dv = -most(square.v - 1, 0, radius); dv <= last_row; ++dv) {
      int first = -most(square.u - 1, 0, radius), last = most(level.width - 2, square.u, radius);
      narrow(square.cosine, -dv * square.sine, first, last);
      narrow(square.sine, dv * square.cosine, first, last);
      if (first > last) continue;
      sample_row(square, level, dv, first, last, weight_.data() + radius + kLanes, samples_);
      spread(samples_, last - first + 1, sums_);
    }
    std::array<float, kDescriptor> sum;
    for (int row = 0; row < kCells; ++row) {
      for (int column = 0; column < kCells; ++column) {
        const int from = (row + 1) * kWide + column + 1;
        const Lanes both = sums_[0][from] + sums_[1][from];
        for (int k = 0; k < kOrientations; ++k) sum[(row * kCells + column) * kOrientations + k] = both[k];
      }
    }
    normalise(sum, descriptor);
  }

 private:
  static float bins(double angle_rad) {
    const double turns = angle_rad / (2 * std::numbers::pi);
    return static_cast<float>((turns - std::floor(turns)) * kOrientations);
  }

  // Room for a row, and the Gaussian of half the cells' width, by pixels along one axis.
  void prepare(int radius, double side) {
    const size_t width = 2 * radius + 1 + 2 * kLanes;
    if (samples_.cell.size() < width) {
      for (auto* values : {&samples_.orientation, &samples_.upper, &samples_.lower, &samples_.left_share})
        values->resize(width);
      samples_.cell.resize(width);
    }
    weight_.assign(width, 0.0f);
    float* middle = weight_.data() + radius + kLanes;
    for (int k = 0; k <= radius; ++k) {
      const double away = k / side;
      middle[k] = middle[-k] = static_cast<float>(std::exp(-2 * away * away / (kCells * kCells)));
    }
  }

  Samples samples_;
  std::vector<float> weight_;
  std::array<Histogram, 2> sums_;
};

}  // namespace

void describe_keypoints(std::span<const ScaleLevel> levels, std::span<const LevelKeypoint> keypoints, uint8_t* descriptor) {
  Describer describer;
  for (const LevelKeypoint& keypoint : keypoints) {
    describer.describe(levels[keypoint.level], keypoint, descriptor);
    descriptor += kDescriptor;
  }
}

}  // namespace hullrecon
