// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "schur/small_factors.h"

#include <atomic>
#include <numeric>

#include "common/parallel.h"

namespace hullrecon {

SmallFactors::SmallFactors(const Model& model, const ReducedLayout& layout) : model_(model) {
  std::vector<int32_t> blocks;
  part_start_.assign(1, 0), value_start_.assign(1, 0);
  std::vector<int32_t> met(layout.blocks() + 1, 0);
  for (Kind kind : {Kind::Prior, Kind::Attitude, Kind::Tray, Kind::Odometry, Kind::Range, Kind::Deviation, Kind::Link,
                    Kind::Plane, Kind::PlanePair, Kind::PlaneRange, Kind::Velocity, Kind::Position}) {
    const auto [first, end] = model.factors_of(kind);
    for (int64_t i = first; i < end; ++i) {
      model.blocks_of(i, blocks);
      int column = 0;
      for (int32_t b : blocks) {
        const int at = layout.block_of(b);
        if (at < 0) continue;
        const bool global = at == layout.blocks();
        const int width = model.blocks()[b].tangent;
        part_.push_back({at, width, column, global ? layout.column(layout.global_of(b)) : -1});
        column += width;
        if (!global) ++met[at + 1];
      }
      model.visit(i, [&](const auto& residual, const auto&, const Robust&) {
        rows_.push_back(std::decay_t<decltype(residual)>::kRows);
      });
      factor_.push_back(i);
      part_start_.push_back(static_cast<int64_t>(part_.size()));
      value_start_.push_back(value_start_.back() + int64_t{rows_.back()} * (column + 1));
    }
  }
  part_.shrink_to_fit();
  value_.resize(value_start_.back());
  std::partial_sum(met.begin(), met.end(), met.begin());
  of_block_start_ = met;
  of_block_.resize(met.back());
  for (int64_t f = 0; f < count(); ++f) {
    for (const Part& part : parts(f)) {
      if (part.border < 0) of_block_[met[part.block]++] = static_cast<int32_t>(f);
    }
  }
}

void SmallFactors::linearise() {
  for_slabs(count(), model_.options().threads, [&](int64_t begin, int64_t end) {
    std::vector<int32_t> blocks;
    std::vector<const double*> x;
    std::vector<double> raw;
    std::vector<double*> J;
    std::vector<int> sizes;
    for (int64_t f = begin; f < end; ++f) {
      model_.blocks_of(factor_[f], blocks);
      const int rows = rows_[f];
      x.clear(), J.clear(), sizes.clear();
      raw.resize(blocks.size() * 9 * rows);
      double* next = raw.data();
      for (int32_t b : blocks) {
        const Block& block = model_.blocks()[b];
        x.push_back(block.data), sizes.push_back(block.size);
        J.push_back(block.tangent > 0 ? next : nullptr);
        next += 9 * rows;
      }
      Eigen::Map<Eigen::MatrixXd> out(&value_[value_start_[f]], rows, (value_start_[f + 1] - value_start_[f]) / rows);
      double residual[9], rho, slope = 1;
      model_.visit(factor_[f], [&](const auto& of, const auto& whitening, const Robust& robust) {
        whitened(of, whitening, sizes, x.data(), residual, J.data());
        robust(Eigen::Map<Eigen::VectorXd>(residual, rows).squaredNorm(), rho, slope);
      });
      const double weight = std::sqrt(slope);
      int column = 0;
      for (size_t k = 0; k < blocks.size(); ++k) {
        const Block& block = model_.blocks()[blocks[k]];
        using Raw = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
        if (block.tangent == 0) continue;
        out.middleCols(column, block.tangent) = weight * Eigen::Map<const Raw>(J[k], rows, block.size).leftCols(block.tangent);
        column += block.tangent;
      }
      out.rightCols<1>() = weight * Eigen::Map<Eigen::VectorXd>(residual, rows);
    }
  });
}

bool SmallFactors::cost(std::array<double, kKindNames.size()>& by_kind) const {
  constexpr int64_t kChunk = 4096;
  const int64_t chunks = (count() + kChunk - 1) / kChunk;
  std::vector<std::array<double, kKindNames.size()>> sums(chunks, {0.0});
  std::atomic<bool> good = true;
  const auto work = [&](int64_t begin, int64_t end) {
    std::vector<int32_t> blocks;
    std::vector<const double*> x;
    for (int64_t f = begin * kChunk; f < std::min(count(), end * kChunk); ++f) {
      model_.blocks_of(factor_[f], blocks);
      x.clear();
      for (int32_t b : blocks) x.push_back(model_.blocks()[b].data);
      double r[9], rho = 0, slope;
      model_.visit(factor_[f], [&](const auto& residual, const auto& whitening, const Robust& robust) {
        if (!whitened(residual, whitening, std::array<int, 0>{}, x.data(), r, nullptr)) good = false;
        robust(Eigen::Map<Eigen::VectorXd>(r, rows_[f]).squaredNorm(), rho, slope);
      });
      sums[f / kChunk][static_cast<size_t>(model_.kind_of(factor_[f]))] += 0.5 * rho;
    }
  };
  for_slabs(chunks, model_.options().threads, work, 1);
  for (const auto& chunk : sums) {
    for (size_t k = 0; k < chunk.size(); ++k) by_kind[k] += chunk[k];
  }
  return good;
}

}  // namespace hullrecon
