// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Surface factors by landmark, for the Schur core: linear at the last accepted point, whitened and robustified.
#pragma once

#include <span>
#include <vector>

#include "schur/image_terms.h"
#include "schur/reduced_layout.h"

namespace hullrecon {

// r + n' delta_landmark + by_hull' delta_hull + by_field sum of weight_k delta_node_k (docs/schur.md, 5).
struct SurfaceTerm {
  Vec3 n, turn;  // by the landmark; by the rotation of T_g_M
  double r, by_field;
  int32_t row, rank;  // in its table; of its landmark
  // The distance falls as the hull moves towards the landmark.
  Twist by_hull() const {
    Twist a;
    a << -n, turn;
    return a;
  }
};

class SurfaceTerms {
 public:
  SurfaceTerms(const Model& model, const ImageTerms& images, const ReducedLayout& layout);

  void linearise();     // at the model's unknowns
  double cost() const;  // robustified, at the model's unknowns

  std::span<const SurfaceTerm> of_landmark(int64_t rank) const {
    return {term_.data() + start_[rank], static_cast<size_t>(start_[rank + 1] - start_[rank])};
  }
  std::span<const int32_t> of_node(int node) const {  // numbers of terms
    return {of_node_.data() + of_node_start_[node], static_cast<size_t>(of_node_start_[node + 1] - of_node_start_[node])};
  }
  const SurfaceTerm& operator[](int64_t term) const { return term_[term]; }
  std::span<const int32_t> nodes(const SurfaceTerm& term) const { return model_.surface_nodes(term.row); }
  std::span<const double> weights(const SurfaceTerm& term) const { return model_.surface_field(term.row).weight; }
  void shelve(Shelf& shelf) { shelf.add(start_, term_, of_node_start_, of_node_); }
  double by_node(const SurfaceTerm& term, int32_t node) const;  // derivative by one of its nodes

 private:
  double residual(const SurfaceTerm& term, const Mat3& global_from_hull, const Vec3& origin, Vec3& n_global) const;
  MixtureLoss loss(const SurfaceTerm& term) const { return model_.surface_loss(term.row); }

  const Model& model_;
  const ImageTerms& images_;
  std::vector<int32_t> start_;  // by rank
  std::vector<SurfaceTerm> term_;
  std::vector<int32_t> of_node_start_, of_node_;
};

}  // namespace hullrecon
