// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Model: what is asked of it anew at every point: associations, labels, costs.
#include "common/parallel.h"
#include "model/model.h"
#include "model/visit.h"

namespace hullrecon {

void Model::refresh(bool trial, bool surface_too) {
  const double *const hull_data = blocks_[block("T_g_M")].data, *const mount = blocks_[block("T_s_d")].data;
  const Motion hull(hull_data);
  const Mat3 hull_from_global = hull.rotation().transpose();
  if (surface_too || options_.method != "naive") {
    association_.refresh_surface(
        [&](int64_t i) { return Vec3(hull_from_global * (landmark(tables_.surface_landmark.data[i]) - hull.t)); });
  }
  const auto ray = [&](int64_t i) {
    const double* const x[] = {blocks_[tables_.range_node.data[i]].data, hull_data, mount};
    const Beam beam = range(i).at(x, 0);
    return std::pair(beam.end_hull, beam.along_hull);
  };
  association_.refresh_range(ray, trial);
}

std::vector<int32_t> Model::labels() const {
  if (!held_labels_.empty()) return held_labels_;
  std::vector<int32_t> out(tables_.surface_landmark.rows());
  for (int64_t i = 0; i < tables_.surface_landmark.rows(); ++i) {
    const auto nodes = surface_nodes_.nodes(i);
    const FieldAt at = surface_nodes_.at(i);
    double field = 0;
    for (size_t k = 0; k < nodes.size(); ++k) field += at.weight[k] * *blocks_[first_node() + nodes[k]].data;
    out[i] = mixture_.on(association_.distance()[i] - field);
  }
  return out;
}

std::array<double, kKindNames.size()> Model::costs() const {
  constexpr int64_t kChunk = 4096;  // sums are formed over fixed chunks, then in order: the same for any threads
  const int64_t count = factors(), chunks = (count + kChunk - 1) / kChunk;
  std::vector<std::array<double, kKindNames.size()>> sums(chunks, {0.0});
  const auto one = [&](int64_t i, std::vector<int32_t>& blocks, std::vector<const double*>& x) {
    blocks_of(i, blocks);
    x.clear();
    for (int32_t b : blocks) x.push_back(blocks_[b].data);
    double rho = 0, slope;
    visit(i, [&](const auto& residual, const auto& whitening, const Robust& robust) {
      Eigen::Matrix<double, std::decay_t<decltype(residual)>::kRows, 1> r;
      if (whitened(residual, whitening, std::array<int, 0>{}, x.data(), r.data(), nullptr)) robust(r.squaredNorm(), rho, slope);
    });
    return 0.5 * rho;
  };
  const auto work = [&](int64_t begin, int64_t end) {
    std::vector<int32_t> blocks;
    std::vector<const double*> x;
    for (int64_t c = begin; c < end; ++c) {
      for (int64_t i = c * kChunk; i < std::min(count, (c + 1) * kChunk); ++i) {
        sums[c][static_cast<int>(kind_of(i))] += one(i, blocks, x);
      }
    }
  };
  for_slabs(chunks, options_.threads, work, 1);
  std::array<double, kKindNames.size()> total{};
  for (const auto& chunk : sums) {
    for (size_t k = 0; k < total.size(); ++k) total[k] += chunk[k];
  }
  return total;
}

}  // namespace hullrecon
