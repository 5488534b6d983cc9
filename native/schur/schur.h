// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The normal equations of the whole problem with the landmarks eliminated, for Levenberg-Marquardt steps.
//
// Derivation, symbols and costs: docs/schur.md, whose equations are cited by number. In short: the images at pose i see
// landmark l displaced by  d = delta_l + E xi_i  (1), where the camera's twist is  xi_i = P_i delta_i + Q_i delta_mount  (2).
// With H_i, g_i the information and gradient of these images by d (4), and K the inverse of the landmark's own damped
// information (6), the information left on the twists i, j is
//     X_ij = [i = j] E_i' H_i E_i - E_i' H_i K H_j E_j,                                                   (9)
// and the reduced system of poses and mount is  S = [P Q]' X [P Q]  (10).
//
// In a part of a problem (docs/schur.md, *Parts*) the interior is eliminated as well, and what is left on its interface and the
// border is joined with that of the other parts (solve/joined_problem.h).
//
// Each row of X is summed by one thread in a fixed order, sums over all rows by fixed chunks: the bytes do not depend on the
// number of threads.
#pragma once

#include <functional>
#include <memory>
#include <memory_resource>
#include <optional>

#include "schur/twist_pattern.h"

namespace hullrecon {

// A step of every free unknown, or a number for each: landmarks by rank, 3 each; the rest as ReducedSystem orders it.
struct StepVector {
  Eigen::VectorXd landmark, reduced;
  void shelve(Shelf& shelf) { shelf.add(landmark, reduced); }
  double dot(const StepVector& other) const { return landmark.dot(other.landmark) + reduced.dot(other.reduced); }
};

class Schur {
 public:
  // interface: of a part, the blocks of the layout that other parts share. None: the model is the whole problem.
  // pages: memory for what is large.
  explicit Schur(Model& model, const std::optional<std::vector<int>>& interface = {},
                 std::pmr::memory_resource* pages = std::pmr::get_default_resource());

  // Robustified cost by kind at the model's unknowns; empty: they cannot be evaluated (or are refused, association.h).
  std::optional<std::array<double, kKindNames.size()>> cost();
  // Everything at the model's unknowns; fills gradient and the diagonal of J'J.
  void linearise();
  void shelve(Shelf& shelf);                   // what grows with the problem and is not in `pages`
  void restore() { images_.place_cameras(); }  // after a point was tried: back at the unknowns of linearise()
  // Solves (J'J + diag(damping)) step = -gradient. False: not positive definite.
  bool step(const StepVector& damping, StepVector& step) { return condense(damping) && finish(step); }

  // The step in halves. Of a part, between them, condensed() and condensed_gradient(), on interface and border, are in
  // the last entries of a StepVector's `reduced`; finish() finds their step in those of `step`.
  bool condense(const StepVector& damping);
  StepVector no_damping() const {
    return {Eigen::VectorXd::Zero(gradient_.landmark.size()), Eigen::VectorXd::Zero(gradient_.reduced.size())};
  }
  bool finish(StepVector& step);
  int interior() const { return reduced_->interior(); }                      // entries of `reduced` before them
  Eigen::Map<Eigen::MatrixXd> condensed() { return reduced_->condensed(); }  // its lower half
  auto condensed_gradient() const { return -rhs_.tail(rhs_.size() - interior()); }

  // Marginals (19), after a condense() without damping; of a part, condensed() then holds those of interface and border.
  bool determines_all() const;  // to working precision; of a part, its own
  void invert() { reduced_->invert(); }
  Eigen::MatrixXd covariance(int a, int b) const { return reduced_->block(a, b); }  // of blocks of the layout that meet
  struct LandmarkCovariance {
    Mat3 own;
    Eigen::Matrix<double, 3, 6> with_hull;  // with T_g_M
    // The blocks that its factors meet, the border the last, their first columns, and what they say of it and of these.
    std::vector<int> block, column;
    Eigen::Matrix3Xd cross;
    Eigen::MatrixX3d turned;  // the same by columns
  };
  void covariance_of_landmark(int64_t rank, LandmarkCovariance& out) const;

  const StepVector& gradient() const { return gradient_; }
  const StepVector& diagonal() const { return diagonal_; }
  // to = the unknowns at `from` moved by step; both as the model lays them out, from the first block on.
  void plus(const std::vector<double>& from, const StepVector& step, std::vector<double>& to) const;

  // Where a number of StepVector stands, for tests: first entry of a block of the layout in `reduced`, rank of a landmark.
  const ReducedLayout& layout() const { return layout_; }
  int offset(int block) const { return reduced_->offset(block); }
  int64_t rank(int64_t landmark) const { return images_.rank(landmark); }
  int32_t landmark(int64_t rank) const { return images_.landmark(rank); }

  struct Seconds {
    double eliminate = 0, factor = 0, back_substitute = 0;
  };
  Seconds seconds;

 private:
  using Vec7 = Eigen::Matrix<double, 7, 1>;
  using Mat6 = Eigen::Matrix<double, 6, 6>;
  using Mat63 = Eigen::Matrix<double, 6, 3>;
  using Mat6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;
  static constexpr int64_t kPoses = 64, kLandmarks = 1024;  // chunks of sums
  static constexpr int64_t kGroup = 256;                    // landmarks whose products with intrinsics are one
  struct Border {                                           // what a chunk adds to the border's own block and right side
    Eigen::MatrixXd own;
    Eigen::VectorXd rhs;
  };

  void differentiate_landmarks();
  void differentiate_poses();
  void differentiate_images(int64_t pose, Vec7& gradient, Vec7& diagonal);
  void differentiate_nodes();
  void differentiate_others();
  void differentiate_border(const Border& of_intrinsics);
  Border differentiate_intrinsics();
  void add_intrinsics_to_border(const Eigen::MatrixXd& own, const Eigen::VectorXd& rhs, Border& sum) const;

  bool invert(const StepVector& damping);
  void eliminate();
  void eliminate_row(int pose, std::vector<int64_t>& place);
  void eliminate_intrinsics(int64_t stretch);
  void reduce_row(int pose, Border& sum);
  void reduce_node(int node, std::vector<double>& row);
  void reduce_other(int block);
  void add_small(int block, Eigen::MatrixXd& own, Eigen::MatrixXd& border);
  void reduce_landmark_border(int64_t rank, Border& sum) const;
  Border reduce_intrinsics() const;
  void back_substitute(StepVector& step) const;

  Vec3 at(int64_t rank) const { return images_.at(rank); }
  Mat3 inverse(int64_t rank) const { return symmetric(inverse_[rank]); }
  auto with_intrinsics(int pose) {
    return with_intrinsics_.middleCols(static_cast<Eigen::Index>(pose) * intrinsics_, intrinsics_);
  }
  auto intrinsics_of(int64_t rank) const {
    return Eigen::Map<const WithIntrinsics>(intrinsics_cross_.data() + 3 * rank * intrinsics_, 3, intrinsics_);
  }
  int64_t groups() const { return (model_.landmarks() + kGroup - 1) / kGroup; }
  int intrinsics_in_border(int column) const { return intrinsics_in_border_[column]; }
  Border chunked(int64_t count, int64_t chunk, const std::function<void(int64_t, Border&)>& work) const;

  Model& model_;
  const ReducedLayout layout_;
  ImageTerms images_;
  SurfaceTerms surface_;
  SmallFactors small_;
  const int threads_;
  TwistPattern pattern_;
  const std::unique_ptr<ReducedSystem> reduced_;
  const bool is_part_;
  const int intrinsics_, hull_, mount_;  // columns of the free intrinsics; first of T_g_M, T_s_ct in the border, -1: held
  std::vector<int> intrinsics_in_border_;

  // At the last accepted point.
  StepVector gradient_, diagonal_;
  std::vector<Mat6> own_;                      // of each pose: sum of E'HE; these and rows of X where images see a landmark
  std::pmr::vector<double> intrinsics_cross_;  // C of each landmark, (3, intrinsics)
  Eigen::MatrixXd intrinsics_own_;             // of the border, before landmarks are eliminated
  // Of the damped system.
  std::pmr::vector<std::array<double, 6>> inverse_;  // K of each landmark
  Eigen::Matrix3Xd gain_;                            // K g of each landmark
  std::pmr::vector<double> x_;                       // X, as pattern_ lays it out
  Mat6X eliminated_;                                 // of each pose's twist: sum of E'H K g (linearise: its gradient)
  std::vector<Mat6> with_hull_;                      // rows of X by T_g_M
  Mat6X with_intrinsics_;                            // and by the free intrinsics, side by side
  Eigen::VectorXd rhs_;
};

}  // namespace hullrecon
