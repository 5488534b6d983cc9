// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "solve/pair_covariance.h"

#include <algorithm>

#include "common/blas_guard.h"
#include "common/parallel.h"
#include "solve/scaled_information.h"
#include "sparse/inverse_columns.h"
#include "sparse/selected_inversion.h"

namespace hullrecon {
namespace {

constexpr int kColumnsCost = 16;  // poses per column: from so many on, the inverse on the factor's pattern costs less
constexpr int kTogether = 8;      // poses whose columns are solved for side by side: neighbours in the tree share the way up

using PosePairs = std::vector<std::array<int32_t, 2>>;

// One pose whose columns are solved for, and what is read from them.
struct Hub {
  int32_t pose;
  std::vector<int64_t> pairs;  // whose other end is read
};

// Scalars of the reduced information, by block.
struct Scalars {
  const Information& information;
  const std::vector<double>& scale;

  std::vector<int> of(int block) const {
    std::vector<int> out;
    const int p = information.position(block);
    for (int k = 0; p >= 0 && k < information.reduced().width(p); ++k) out.push_back(information.reduced().offset(p) + k);
    return out;
  }
};

// In how many pairs each pose is named.
std::vector<int32_t> times_named(const PosePairs& pairs, int64_t poses) {
  std::vector<int32_t> met(poses, 0);
  for (const auto& [i, j] : pairs) ++met[i], ++met[j];
  return met;
}

int64_t count_named(const std::vector<int32_t>& named) {
  return std::count_if(named.begin(), named.end(), [](int32_t times) { return times > 0; });
}

// Each pair is given to that end which more pairs have. Poses that are named and are given none are hubs too where they are
// few: columns for all would cost the square of their number where one pose is paired with all others, and the inverse on the
// factor's pattern, which holds their own blocks as well, costs as much as some columns a hundred poses. In the tree's order.
std::vector<Hub> hubs_of(const PosePairs& pairs, const std::vector<int32_t>& named, const Information& information,
                         const SupernodalFactor& factor) {
  std::vector<Hub> hubs;
  std::vector<int32_t> at(named.size(), -1);
  for (size_t k = 0; k < pairs.size(); ++k) {
    const auto [i, j] = pairs[k];
    const int32_t hub = named[j] > named[i] ? j : i;
    if (at[hub] < 0) at[hub] = static_cast<int32_t>(hubs.size()), hubs.push_back({hub, {}});
    hubs[at[hub]].pairs.push_back(static_cast<int64_t>(k));
  }
  if (kColumnsCost * (count_named(named) - static_cast<int64_t>(hubs.size())) <= static_cast<int64_t>(named.size())) {
    for (size_t i = 0; i < named.size(); ++i) {
      if (named[i] > 0 && at[i] < 0) hubs.push_back({static_cast<int32_t>(i), {}});
    }
  }
  const auto place = [&](const Hub& hub) {
    return factor.position(information.reduced().offset(information.position(hub.pose)));
  };
  std::sort(hubs.begin(), hubs.end(), [&](const Hub& a, const Hub& b) { return place(a) < place(b); });
  return hubs;
}

// Own blocks (7, 7) of all poses that are named, from the inverse on the factor's pattern.
std::vector<double> own_blocks(const Lower& lower, const Scalars& scalars, const std::vector<int32_t>& named) {
  std::vector<double> own(named.size() * 49, 0.0);
  const SelectedInverse inverse(lower);
  for (size_t i = 0; i < named.size(); ++i) {
    if (named[i] == 0) continue;
    const auto rows = scalars.of(static_cast<int>(i));
    for (size_t r = 0; r < rows.size(); ++r) {
      for (size_t c = 0; c < rows.size(); ++c) {
        own[49 * i + 7 * r + c] = inverse(rows[r], rows[c]) * scalars.scale[rows[r]] * scalars.scale[rows[c]];
      }
    }
  }
  return own;
}

// Writes what a solve holds of rows i by the columns of j, `first` being the number of j's first column.
void put(const InverseColumns& inverse, const Scalars& scalars, int i, int j, int first, double* out, int stride, bool turned) {
  const auto rows = scalars.of(i), columns = scalars.of(j);
  for (size_t r = 0; r < rows.size(); ++r) {
    for (size_t c = 0; c < columns.size(); ++c) {
      const double v = inverse(rows[r], first + static_cast<int>(c)) * scalars.scale[rows[r]] * scalars.scale[columns[c]];
      out[turned ? c * stride + r : r * stride + c] = v;
    }
  }
}

}  // namespace

PairCovariance pair_covariance(Model& model, const PosePairs& pairs) {
  const BlasGuard guard;
  model.refresh(false, true);
  Information information(model);
  const ScaledInformation scaled(model, information);
  std::unique_ptr<SupernodalFactor> factor;
  try {
    factor = std::make_unique<SupernodalFactor>(scaled.lower);
  } catch (const Singular&) {
    scaled.refuse(model, information);
  }
  const Scalars scalars{information, scaled.scale};
  const auto named = times_named(pairs, model.poses());
  const auto hubs = hubs_of(pairs, named, information, *factor);
  PairCovariance out;
  out.pose.assign(pairs.size() * 196, 0.0), out.pose_mount.assign(pairs.size() * 84, 0.0), out.mount.assign(36, 0.0);
  const bool all_are_hubs = static_cast<int64_t>(hubs.size()) == count_named(named);
  std::vector<double> own(model.poses() * 49, 0.0);
  if (!all_are_hubs) own = own_blocks(scaled.lower, scalars, named);
  std::vector<double> with_mount(model.poses() * 42, 0.0);
  const auto append = [](std::vector<int>& to, const std::vector<int>& more) { to.insert(to.end(), more.begin(), more.end()); };

  // Columns of T_s_ct at every pose that is named.
  if (const int mount = model.block("T_s_ct"); information.position(mount) >= 0) {
    InverseColumns inverse(*factor);
    std::vector<int> rows;
    for (int32_t i = 0; i < model.poses(); ++i) {
      if (named[i] > 0) append(rows, scalars.of(i));
    }
    inverse.solve(scalars.of(mount), rows);
    put(inverse, scalars, mount, mount, 0, out.mount.data(), 6, false);
    for (int32_t i = 0; i < model.poses(); ++i) {
      if (named[i] > 0) put(inverse, scalars, i, mount, 0, &with_mount[42 * i], 6, false);
    }
  }
  // Columns of the poses, at the other ends of their pairs.
  const auto batches = static_cast<int64_t>((hubs.size() + kTogether - 1) / kTogether);
  const auto work = [&](int64_t begin, int64_t end) {
    InverseColumns inverse(*factor);
    std::vector<int> rows, columns, first;
    for (int64_t b = begin; b < end; ++b) {
      const size_t from = b * kTogether, to = std::min(hubs.size(), from + kTogether);
      rows.clear(), columns.clear(), first.clear();
      for (size_t h = from; h < to; ++h) {
        first.push_back(static_cast<int>(columns.size()));
        append(columns, scalars.of(hubs[h].pose));
        for (int64_t k : hubs[h].pairs) append(rows, scalars.of(pairs[k][0])), append(rows, scalars.of(pairs[k][1]));
      }
      inverse.solve(columns, rows);
      for (size_t h = from; h < to; ++h) {
        const int32_t hub = hubs[h].pose;
        if (all_are_hubs) put(inverse, scalars, hub, hub, first[h - from], &own[49 * hub], 7, false);
        for (int64_t k : hubs[h].pairs) {
          const auto [i, j] = pairs[k];
          const int32_t other = i == hub ? j : i;
          put(inverse, scalars, other, hub, first[h - from], &out.pose[196 * k + 7], 14, i == hub);
        }
      }
    }
  };
  for_slabs(batches, model.options().threads, work, 1);
  for (size_t k = 0; k < pairs.size(); ++k) {
    double* const joint = &out.pose[196 * k];
    for (int e = 0; e < 2; ++e) {
      const int32_t i = pairs[k][e];
      for (int r = 0; r < 7; ++r) std::copy_n(&own[49 * i + 7 * r], 7, joint + 14 * (7 * e + r) + 7 * e);
      std::copy_n(&with_mount[42 * i], 42, &out.pose_mount[84 * k + 42 * e]);
    }
    for (int r = 0; r < 7; ++r) {
      for (int c = 0; c < 7; ++c) joint[14 * (7 + c) + r] = joint[14 * r + 7 + c];
    }
  }
  return out;
}

}  // namespace hullrecon
