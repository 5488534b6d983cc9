// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "schur/small_factors.h"

#include <algorithm>
#include <atomic>
#include <numeric>

#include "common/parallel.h"

namespace hullrecon {

namespace {

// to += a' b, columns of kRows numbers (0: of `rows`); to: by columns, `stride` apart. For products too small for a library.
template <int kRows>
void add_product_of(double* to, int64_t stride, const double* a, int a_columns, const double* b, int b_columns, int64_t rows) {
  const int64_t n = kRows > 0 ? kRows : rows;
  for (int c = 0; c < b_columns; ++c) {
    for (int r = 0; r < a_columns; ++r) {
      double sum = 0;
      for (int64_t k = 0; k < n; ++k) sum += a[r * n + k] * b[c * n + k];
      to[c * stride + r] += sum;
    }
  }
}

void add_product(double* to, int64_t stride, const double* a, int a_columns, const double* b, int b_columns, int64_t rows) {
  const auto of = rows == 1   ? add_product_of<1>
                  : rows == 3 ? add_product_of<3>
                  : rows == 5 ? add_product_of<5>
                  : rows == 6 ? add_product_of<6>
                              : add_product_of<0>;
  of(to, stride, a, a_columns, b, b_columns, rows);
}

}  // namespace

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
      rows_.push_back(model.rows_of(i));
      factor_.push_back(i);
      part_start_.push_back(static_cast<int64_t>(part_.size()));
      value_start_.push_back(value_start_.back() + int64_t{rows_.back()} * (column + 1));
    }
  }
  part_.shrink_to_fit();
  std::partial_sum(met.begin(), met.end(), met.begin());
  of_block_start_ = met;
  of_block_.resize(met.back());
  for (int64_t f = 0; f < count(); ++f) {
    for (const Part& part : parts(f)) {
      if (part.border < 0) of_block_[met[part.block]++] = static_cast<int32_t>(f);
    }
  }
  lay_out(layout);
}

// Two blocks stand in the information when a factor meets both.
void SmallFactors::lay_out(const ReducedLayout& layout) {
  std::vector<int> width;
  std::vector<uint64_t> pairs;
  const auto pair = [&](int column, int row) { pairs.push_back(uint64_t(column) << 32 | uint32_t(row)); };
  for (int b = 0; b <= layout.blocks(); ++b) width.push_back(layout.width(b)), pair(b, b);
  for (int64_t f = 0; f < count(); ++f) {
    for (const Part& a : parts(f)) {
      for (const Part& b : parts(f)) {
        if (b.block > a.block) pair(a.block, b.block);
      }
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  information_ = BlockMatrix(std::move(width), pairs);
  gradient_.resize(information_.size());
}

// Chunks of factors, one after the other: their rows are evaluated, and each thread adds them, in order, to the columns of
// blocks that it owns. Every sum has the order of the factors, for any number of threads.
void SmallFactors::linearise() {
  constexpr int64_t kChunk = 4096;
  const int threads = thread_count(model_.options().threads);
  std::vector<double> values;
  information_.clear(), gradient_.setZero();
  for (int64_t first = 0; first < count(); first += kChunk) {
    const int64_t end = std::min(count(), first + kChunk);
    values.resize(value_start_[end] - value_start_[first]);
    const auto rows = [&](int64_t f) { return &values[value_start_[f] - value_start_[first]]; };
    for_slabs(end - first, threads, [&](int64_t begin, int64_t stop) {
      Scratch scratch;
      for (int64_t f = first + begin; f < first + stop; ++f) evaluate(f, rows(f), scratch);
    });
    const auto owned = [&](int64_t owner, int64_t) {
      for (int64_t f = first; f < end; ++f) add(f, rows(f), static_cast<int>(owner), threads);
    };
    for_slabs(threads, threads, owned, 1);
  }
}

// A factor's rows, whitened and robustified, by columns; the last is the residual.
void SmallFactors::evaluate(int64_t f, double* to, Scratch& s) const {
  model_.blocks_of(factor_[f], s.blocks);
  const int rows = rows_[f];
  s.x.clear(), s.J.clear(), s.sizes.clear();
  size_t numbers = 0;
  for (int32_t b : s.blocks) numbers += model_.blocks()[b].size * rows;
  s.raw.resize(numbers);
  double* next = s.raw.data();
  for (int32_t b : s.blocks) {
    const Block& block = model_.blocks()[b];
    s.x.push_back(block.data), s.sizes.push_back(block.size);
    s.J.push_back(block.tangent > 0 ? next : nullptr);
    next += block.size * rows;
  }
  Eigen::Map<Eigen::MatrixXd> out(to, rows, (value_start_[f + 1] - value_start_[f]) / rows);
  double residual[kMostRows], rho, slope = 1;
  model_.evaluate(factor_[f], s.sizes, s.x.data(), residual, s.J.data());
  model_.robust(factor_[f])(Eigen::Map<Eigen::VectorXd>(residual, rows).squaredNorm(), rho, slope);
  const double weight = std::sqrt(slope);
  int column = 0;
  for (size_t k = 0; k < s.blocks.size(); ++k) {
    const Block& block = model_.blocks()[s.blocks[k]];
    using Raw = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    if (block.tangent == 0) continue;
    out.middleCols(column, block.tangent) = weight * Eigen::Map<const Raw>(s.J[k], rows, block.size).leftCols(block.tangent);
    column += block.tangent;
  }
  out.rightCols<1>() = weight * Eigen::Map<Eigen::VectorXd>(residual, rows);
}

// Adds a factor's rows to the columns of one owner. Sixteen blocks that stand together have one.
void SmallFactors::add(int64_t f, const double* rows, int owner, int owners) {
  const int64_t m = rows_[f];
  const double* const residual = rows + (value_start_[f + 1] - value_start_[f]) - m;
  for (const Part& a : parts(f)) {
    if (a.block / 16 % owners != owner) continue;
    const double* const J = rows + a.column * m;
    const int at = std::max(a.border, 0);
    add_product(&gradient_[information_.offset(a.block) + at], a.width, J, a.width, residual, 1, m);
    for (const Part& b : parts(f)) {
      if (b.block < a.block || (b.block == a.block && b.border < a.border)) continue;
      auto to = information_.lower(b.block, a.block);
      add_product(&to(std::max(b.border, 0), at), to.rows(), rows + b.column * m, b.width, J, a.width, m);
    }
  }
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
      double r[kMostRows], rho = 0, slope;
      if (!model_.evaluate(factor_[f], {}, x.data(), r, nullptr)) good = false;
      model_.robust(factor_[f])(Eigen::Map<Eigen::VectorXd>(r, rows_[f]).squaredNorm(), rho, slope);
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
