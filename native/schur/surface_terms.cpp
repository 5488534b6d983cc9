// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "schur/surface_terms.h"

#include <algorithm>
#include <numeric>

#include "common/parallel.h"

namespace hullrecon {

// Counting sorts: terms by landmark, and their numbers by node of the field.
SurfaceTerms::SurfaceTerms(const Model& model, const ImageTerms& images, const ReducedLayout& layout)
    : model_(model), images_(images) {
  const auto [first, end] = model_.factors_of(Kind::Surface);
  start_.assign(model_.landmarks() + 1, 0);
  const auto rank_of = [&](int64_t row) { return images_.rank(model_.tables().surface_landmark.data[row]); };
  for (int64_t f = first; f < end; ++f) ++start_[rank_of(model_.row_of(f)) + 1];
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  term_.resize(end - first);
  std::vector<int32_t> next(start_);
  for (int64_t f = first; f < end; ++f) {
    const auto row = static_cast<int32_t>(model_.row_of(f));
    const auto rank = static_cast<int32_t>(rank_of(row));
    term_[next[rank]++] = {Vec3::Zero(), Vec3::Zero(), 0, 0, row, rank};
  }
  of_node_start_.assign(layout.nodes() + 1, 0);
  if (layout.nodes() == 0) return;
  for (const SurfaceTerm& term : term_) {
    for (int32_t node : nodes(term)) ++of_node_start_[node + 1];
  }
  std::partial_sum(of_node_start_.begin(), of_node_start_.end(), of_node_start_.begin());
  of_node_.resize(of_node_start_.back());
  std::vector<int32_t> at(of_node_start_);
  for (size_t k = 0; k < term_.size(); ++k) {
    for (int32_t node : nodes(term_[k])) of_node_[at[node]++] = static_cast<int32_t>(k);
  }
}

// Whitened. origin: of M in g; n_global: the facet's normal.
double SurfaceTerms::residual(const SurfaceTerm& term, const Mat3& global_from_hull, const Vec3& origin, Vec3& n_global) const {
  const Facet& facet = *model_.association().surface(term.row);
  const auto nodes = this->nodes(term);
  const auto weights = this->weights(term);
  n_global.noalias() = global_from_hull * facet.normal;
  double r = n_global.dot(images_.at(term.rank) - origin) + facet.offset;
  for (size_t m = 0; m < nodes.size(); ++m) r -= weights[m] * *model_.blocks()[model_.first_node() + nodes[m]].data;
  return r / model_.options().sigma_on;
}

double SurfaceTerms::cost() const {
  constexpr int64_t kChunk = 1024;
  const Motion hull(model_.blocks()[model_.block("T_g_M")].data);
  const Mat3 global_from_hull = hull.rotation();
  const auto count = static_cast<int64_t>(term_.size()), chunks = (count + kChunk - 1) / kChunk;
  std::vector<double> sums(chunks, 0.0);
  const auto work = [&](int64_t begin, int64_t end) {
    double rho, slope;
    Vec3 normal;
    for (int64_t k = begin * kChunk; k < std::min(count, end * kChunk); ++k) {
      const double r = residual(term_[k], global_from_hull, hull.t, normal);
      loss(term_[k])(r * r, rho, slope);
      sums[k / kChunk] += 0.5 * rho;
    }
  };
  for_slabs(chunks, model_.options().threads, work, 1);
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

void SurfaceTerms::linearise() {
  const Motion hull(model_.blocks()[model_.block("T_g_M")].data);
  const Mat3 global_from_hull = hull.rotation();
  for_slabs(static_cast<int64_t>(term_.size()), model_.options().threads, [&](int64_t begin, int64_t end) {
    double rho, slope;
    for (int64_t k = begin; k < end; ++k) {
      SurfaceTerm& term = term_[k];
      const double r = residual(term, global_from_hull, hull.t, term.n);
      loss(term)(r * r, rho, slope);
      const double root = std::sqrt(slope), scale = root / model_.options().sigma_on;
      term.n *= scale, term.r = root * r, term.by_field = -scale;
      term.turn.noalias() = global_from_hull.transpose() * term.n.cross(images_.at(term.rank) - hull.t);
    }
  });
}

double SurfaceTerms::by_node(const SurfaceTerm& term, int32_t node) const {
  const auto nodes = this->nodes(term);
  return term.by_field * weights(term)[std::find(nodes.begin(), nodes.end(), node) - nodes.begin()];
}

}  // namespace hullrecon
