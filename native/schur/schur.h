// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The normal equations of the whole problem with the landmarks eliminated, for Levenberg and Marquardt's steps. In words:
//
//   The images at pose i see landmark l displaced by  d = delta_l + E xi_i,  E = [I, -hat(l - origin_i)],  where the twist of
//   the camera is  xi_i = P_i delta_i + Q_i delta_mount  (camera_chain.h). With H_i, b_i the information and gradient of these images
//   by d, V = sum H_i + surface, K = (V + damping)^-1, the information left on twists i, j is
//       X_ij = [i = j] E_i' H_i E_i - E_i' H_i K H_j E_j,
//   and the reduced system of poses and mount is  S = [P Q]' X [P Q].
//
// A surface factor n (d_l) + a (T_g_M) + s w (nodes) meets the landmark in one direction only; the rare free optics (T_ct_cb,
// lenses) meet it by three columns each, C. Each row of X is summed by one thread in a fixed order, sums over all rows by fixed
// chunks: the bytes do not depend on the number of threads.
#pragma once

#include <functional>
#include <optional>

#include "schur/image_terms.h"
#include "schur/small_factors.h"
#include "sparse/reduced_system.h"

namespace hullrecon {

// A step of every free unknown, or a number for each: landmarks by rank, 3 each; the rest as Reduced orders it.
struct Split {
  Eigen::VectorXd landmark, kept;
  double dot(const Split& other) const { return landmark.dot(other.landmark) + kept.dot(other.kept); }
};

class Schur {
 public:
  explicit Schur(Model& model);

  // Robustified cost by kind at the model's unknowns; empty: they cannot be evaluated (or are refused, association.h).
  std::optional<std::array<double, kKindNames.size()>> cost();
  // Everything at the model's unknowns; fills gradient and the diagonal of J'J.
  void linearise();
  void restore() { sights_.place_arms(); }  // after a point was tried: back at the unknowns of linearise()
  // Solves (J'J + diag(damping)) step = -gradient. False: not positive definite.
  bool step(const Split& damping, Split& step);

  const Split& gradient() const { return gradient_; }
  const Split& diagonal() const { return diagonal_; }
  // to = the unknowns at `from` moved by step; both as the model lays them out, from the first block on.
  void plus(const std::vector<double>& from, const Split& step, std::vector<double>& to) const;

  struct Seconds {
    double eliminate = 0, factor = 0, back_substitute = 0;
  };
  Seconds seconds;

 private:
  using Vec6 = Eigen::Matrix<double, 6, 1>;
  using Mat6 = Eigen::Matrix<double, 6, 6>;
  using Mat63 = Eigen::Matrix<double, 6, 3>;
  // A surface factor, whitened and robustified: its residual, its derivative by the landmark, by T_g_M's turn, and by the
  // field's nodes (times their weights).
  struct SurfaceRow {
    Vec3 n, turn;
    double r, by_field;
    int32_t row, rank;
    // By T_g_M: the distance falls as the hull moves towards the landmark, and by the turn's arm.
    Vec6 by_hull() const {
      Vec6 a;
      a << -n, turn;
      return a;
    }
  };
  static constexpr int64_t kPoses = 64, kLandmarks = 1024, kFactors = 1024;  // chunks of sums
  struct Border {  // what a chunk adds to the border's own block and right side
    Eigen::MatrixXd own;
    Eigen::VectorXd rhs;
  };

  void sort_surface();
  void find_pattern();
  std::vector<int32_t> neighbours_of(int block, std::vector<char>& met) const;
  // Whitened; n_global: the facet's normal. origin: of M in g.
  double surface_residual(int64_t k, const Mat3& global_from_hull, const Vec3& origin, Vec3& n_global) const;
  double cost_of_surface() const;
  void linearise_surface();
  void differentiate_landmarks();
  void differentiate_poses();
  void differentiate_nodes();
  void differentiate_border();
  bool invert(const Split& damping);
  void eliminate();
  void eliminate_row(int pose, std::vector<int64_t>& place);
  void reduce_row(int pose, Border& sum);
  void reduce_node(int node, std::vector<double>& row);
  void add_small(int block, Eigen::MatrixXd& own, Eigen::MatrixXd& border);
  void border_of_landmark(int64_t rank, Border& sum) const;
  void border_of_small(int64_t f, Border& sum) const;
  void back_substitute(Split& step) const;
  double weight_of(int32_t surface_row, int32_t node) const;
  Mat3 inverse(int64_t rank) const {
    const auto& k = inverse_[rank];
    Mat3 m;
    m << k[0], k[1], k[2], k[1], k[3], k[4], k[2], k[4], k[5];
    return m;
  }
  Vec3 at(int64_t rank) const { return model_.landmark(sights_.landmark(rank)); }
  std::span<const SurfaceRow> surfaces(int64_t rank) const {
    return {surface_.data() + surface_start_[rank], static_cast<size_t>(surface_start_[rank + 1] - surface_start_[rank])};
  }
  auto optics_of(int64_t rank) const { return optics_cross_.middleCols(rank * optics_, optics_); }
  int optics_in_border(int column) const;
  Border chunked(int64_t count, int64_t chunk, const std::function<void(int64_t, Border&)>& work) const;

  Model& model_;
  Kept kept_;
  Sights sights_;
  SmallFactors small_;
  int threads_, optics_, hull_, mount_;       // columns of the free optics; of T_g_M and T_s_ct in the border, -1: held
  std::vector<int32_t> views_start_, views_;  // by pose
  std::vector<int32_t> surface_start_;        // by rank
  std::vector<SurfaceRow> surface_;
  std::vector<int32_t> of_node_start_, of_node_;  // surface rows by node
  // X: blocks of each pose's row from the diagonal on, 6 by 6 with poses and 6 by 1 with nodes; and where they stand by column.
  std::vector<int64_t> upper_start_, lower_start_, x_start_;
  std::vector<int32_t> upper_;
  std::vector<std::pair<int32_t, int64_t>> lower_;  // row, place in x_
  std::vector<double> x_;
  std::vector<Mat6> own_, with_hull_;  // E'HE of each pose; X by T_g_M
  std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>> with_optics_;
  Eigen::Matrix<double, 6, Eigen::Dynamic> eliminated_;  // of each pose's twist: sum of E'H K b
  std::vector<std::array<double, 6>> inverse_;           // K
  Eigen::Matrix3Xd gain_, optics_cross_;                 // K b, C
  std::unique_ptr<Reduced> reduced_;
  Split gradient_, diagonal_;
  Eigen::VectorXd rhs_;
  Eigen::MatrixXd optics_own_;  // of the border, before landmarks are eliminated
};

}  // namespace hullrecon
