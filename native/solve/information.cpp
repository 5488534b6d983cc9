// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "solve/information.h"

#include <amd.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

#include "common/errors.h"

namespace hullrecon {
namespace {

using BlockPairs = std::vector<uint64_t>;

void unique(BlockPairs& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

uint64_t pair_of(uint32_t column, uint32_t row) {
  return (uint64_t{column} << 32) | row;
}

// Every pair among the blocks of a factor, or of a landmark's factors, met once it is eliminated. Block numbers, a <= b.
class Cliques {
 public:
  void add(std::vector<int32_t> blocks) {
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    for (size_t a = 0; a < blocks.size(); ++a) {
      for (size_t b = a; b < blocks.size(); ++b) pairs_.push_back(pair_of(blocks[a], blocks[b]));
    }
    if (pairs_.size() < limit_) return;
    unique(pairs_);
    limit_ = std::max<size_t>(1 << 24, 2 * pairs_.size());
  }
  BlockPairs take() {
    unique(pairs_);
    return std::move(pairs_);
  }

 private:
  BlockPairs pairs_;
  size_t limit_ = 1 << 24;
};

// Fill-reducing order of the blocks below `border`; those of the border (the globals, met by nearly all) come last.
std::vector<int> fill_reducing_order(const BlockPairs& pairs, const std::vector<int>& blocks,
                                     const std::vector<char>& in_border) {
  std::vector<int> inner, local(in_border.size(), -1);
  for (int b : blocks) {
    if (in_border[b]) continue;
    local[b] = static_cast<int>(inner.size());
    inner.push_back(b);
  }
  const int n = static_cast<int>(inner.size());
  std::vector<int> start(n + 1, 0), row, permutation(n);
  for (uint64_t pair : pairs) {
    const int a = local[pair >> 32], b = local[static_cast<uint32_t>(pair)];
    if (a < 0 || b < 0 || a == b) continue;
    ++start[a + 1];
    row.push_back(b);
  }
  for (int i = 0; i < n; ++i) start[i + 1] += start[i];
  if (n > 0) amd_order(n, start.data(), row.data(), permutation.data(), nullptr, nullptr);
  std::vector<int> order;
  for (int p : permutation) order.push_back(inner[p]);
  for (int b : blocks) {
    if (in_border[b]) order.push_back(b);
  }
  return order;
}

}  // namespace

void LandmarkInformation::gather(const Model& model, const std::vector<int64_t>& factors, const std::vector<int>& position,
                                 LinearFactor& linear, BlockMatrix& rest) {
  own.setZero();
  places.clear(), cross.clear();
  for (int64_t i : factors) {
    linear.at(model, i);
    const double information = linear.weight * linear.weight;
    const size_t self =
        std::find_if(linear.blocks.begin(), linear.blocks.end(), [&](int32_t b) { return model.is_landmark(b); }) -
        linear.blocks.begin();
    own.noalias() += information * linear.by[self].transpose() * linear.by[self];
    for (size_t k = 0; k < linear.blocks.size(); ++k) {
      const int place = position[linear.blocks[k]];
      if (place < 0) continue;
      const size_t at = std::find(places.begin(), places.end(), place) - places.begin();
      if (at == places.size()) {
        places.push_back(place);
        cross.push_back(Eigen::MatrixXd::Zero(3, linear.by[k].cols()));
      }
      cross[at].noalias() += information * linear.by[self].transpose() * linear.by[k];
      for (size_t m = 0; m <= k; ++m) {
        if (position[linear.blocks[m]] >= 0)
          rest.add(place, position[linear.blocks[m]], information * linear.by[k].transpose() * linear.by[m]);
      }
    }
  }
}

Eigen::Matrix3d Information::invert(const LandmarkInformation& landmark, int64_t index) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(landmark.own);
  const Eigen::Vector3d& value = eigen.eigenvalues();
  if (!(value[0] > 1e-13 * value[2])) {
    const Eigen::Vector3d d = eigen.eigenvectors().col(0);
    const std::string along = std::to_string(d[0]) + ", " + std::to_string(d[1]) + ", " + std::to_string(d[2]);
    throw StageError("its position along (" + along + ") in g is not determined", "landmark " + std::to_string(index),
                     "leave out landmarks without two views or a surface factor");
  }
  return eigen.eigenvectors() * value.cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose();
}

Information::Information(const Model& model) : reduced_(pattern(model)) {
  eliminate(model);
}

BlockMatrix Information::pattern(const Model& model) {
  const auto first = static_cast<int32_t>(model.poses()), last = static_cast<int32_t>(first + model.landmarks());
  const auto kept = [&](int32_t b) { return (b < first || b >= last) && model.blocks()[b].tangent > 0; };
  of_landmark_.resize(model.landmarks());
  Cliques cliques;
  const auto add_kept = [&](const std::vector<int32_t>& blocks, std::vector<int32_t>& to) {
    for (int32_t b : blocks) {
      if (kept(b)) to.push_back(b);
    }
  };
  std::vector<int32_t> blocks_of_factor;
  for (int64_t i = 0; i < model.factors(); ++i) {
    model.blocks_of(i, blocks_of_factor);
    const auto& blocks = blocks_of_factor;
    const auto at = std::find_if(blocks.begin(), blocks.end(), [&](int32_t b) { return b >= first && b < last; });
    if (at != blocks.end()) {
      of_landmark_[*at - first].push_back(i);
      continue;
    }
    free_of_landmarks_.push_back(i);
    std::vector<int32_t> clique;
    add_kept(blocks, clique);
    cliques.add(std::move(clique));
  }
  for (const auto& factors : of_landmark_) {
    std::vector<int32_t> clique;
    for (int64_t i : factors) model.blocks_of(i, blocks_of_factor), add_kept(blocks_of_factor, clique);
    cliques.add(std::move(clique));
  }
  // The border: globals, each beside every pose, so that joint covariances with them are on the pattern.
  std::vector<char> border(model.blocks().size());
  std::vector<int> blocks;
  for (int32_t b = 0; b < static_cast<int32_t>(model.blocks().size()); ++b) {
    border[b] = b >= last && b < model.first_node();
    if (kept(b)) blocks.push_back(b), cliques.add({b});
  }
  const int32_t hull = model.block("T_g_M");
  for (int32_t b : blocks) {
    if (kept(hull)) cliques.add({b, hull});
  }
  const BlockPairs met = cliques.take();
  order_ = fill_reducing_order(met, blocks, border);
  position_.assign(model.blocks().size(), -1);
  std::vector<int> width;
  for (size_t p = 0; p < order_.size(); ++p) {
    position_[order_[p]] = static_cast<int>(p);
    width.push_back(model.blocks()[order_[p]].tangent);
  }
  BlockPairs placed;
  placed.reserve(met.size());
  for (uint64_t pair : met) {
    const auto [column, row] = std::minmax({position_[pair >> 32], position_[static_cast<uint32_t>(pair)]});
    placed.push_back(pair_of(column, row));
  }
  std::sort(placed.begin(), placed.end());
  return BlockMatrix(std::move(width), placed);
}

void Information::eliminate(const Model& model) {
  LinearFactor linear;
  for (int64_t i : free_of_landmarks_) {
    linear.at(model, i);
    const double information = linear.weight * linear.weight;
    for (size_t k = 0; k < linear.blocks.size(); ++k) {
      for (size_t m = 0; m <= k; ++m) {
        const int row = position_[linear.blocks[k]], column = position_[linear.blocks[m]];
        if (row >= 0 && column >= 0) reduced_.add(row, column, information * linear.by[k].transpose() * linear.by[m]);
      }
    }
  }
  LandmarkInformation landmark;
  for (size_t l = 0; l < of_landmark_.size(); ++l) {
    landmark.gather(model, of_landmark_[l], position_, linear, reduced_);
    const Eigen::Matrix3d covariance = invert(landmark, static_cast<int64_t>(l));
    for (size_t a = 0; a < landmark.places.size(); ++a) {
      const Eigen::MatrixXd gain = landmark.cross[a].transpose() * covariance;
      for (size_t b = 0; b <= a; ++b) reduced_.add(landmark.places[a], landmark.places[b], -gain * landmark.cross[b]);
    }
  }
}

}  // namespace hullrecon
