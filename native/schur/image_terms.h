// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Stereo and mono factors by landmark, for the Schur core: ordered once, evaluated without virtual calls.
#pragma once

#include <array>
#include <memory>
#include <memory_resource>
#include <span>
#include <vector>

#include "factors/lens.h"
#include "model/model.h"
#include "schur/camera_chain.h"

namespace hullrecon {

// Symmetric 3 by 3 matrix of xx xy xz yy yz zz.
inline Mat3 symmetric(const std::array<double, 6>& h) {
  Mat3 m;
  m << h[0], h[1], h[2], h[1], h[3], h[4], h[2], h[4], h[5];
  return m;
}

// What all images at one pose say of one landmark: information H and gradient (both robustified) by its apparent displacement
// in g (docs/schur.md, 4).
struct View {
  std::array<double, 6> information;
  Vec3 gradient;
  int32_t pose, landmark;  // landmark: by rank
  int32_t first_observation;

  Mat3 matrix() const { return symmetric(information); }
};

// Columns of T_ct_cb, the cameras' intrinsics and their lenses, those that are free, side by side. Few dives free T_ct_cb and
// intrinsics, so they are not fast.
class FreeIntrinsics {
 public:
  explicit FreeIntrinsics(const Model& model);
  int width() const { return width_; }
  // First column; -1: held.
  int mount() const { return at_[0]; }  // of T_ct_cb
  int of_top() const { return at_[1]; }
  int of_bottom() const { return at_[2]; }
  int lens(int camera) const { return at_[3 + camera]; }
  int before_lenses() const { return before_lenses_; }  // columns

  // In the order of their columns, which is that of the border.
  static constexpr std::array<Global, 5> kBlocks{kBottom, kTopIntrinsics, kBottomIntrinsics, kTopLens, kBottomLens};

 private:
  std::array<int, 5> at_;
  int before_lenses_ = 0;
  int width_ = 0;
};

// Information of images between a landmark's displacement and the intrinsics, (3, width). Rows are contiguous, so sums are of
// vectors.
using WithIntrinsics = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;

class ImageTerms {
 public:
  // pages: memory for what grows with the images.
  explicit ImageTerms(const Model& model, std::pmr::memory_resource* pages = std::pmr::get_default_resource());

  // Landmarks by rank: those first seen from one pose stand together, so that neighbours in memory are neighbours on the hull.
  int32_t landmark(int64_t rank) const { return order_[rank]; }
  int64_t rank(int64_t landmark) const { return rank_[landmark]; }
  Vec3 at(int64_t rank) const { return model_.landmark(order_[rank]); }  // m, in g

  // Views are numbered by landmark, then by pose.
  const View& view(int64_t i) const { return view_[i]; }
  int32_t first_view(int64_t rank) const { return view_start_[rank]; }
  std::span<const View> views_of_landmark(int64_t rank) const {
    return {view_.data() + view_start_[rank], static_cast<size_t>(view_start_[rank + 1] - view_start_[rank])};
  }
  std::span<const int32_t> views_of_pose(int64_t pose) const {
    return {of_pose_.data() + of_pose_start_[pose], static_cast<size_t>(of_pose_start_[pose + 1] - of_pose_start_[pose])};
  }
  // Views of kStretch poses that follow each other, landmark by landmark. None are kept where no intrinsics are free.
  static constexpr int64_t kStretch = 8;
  int64_t stretches() const { return static_cast<int64_t>(of_stretch_start_.size()) - 1; }
  std::span<const int32_t> views_of_stretch(int64_t k) const {
    return {of_stretch_.data() + of_stretch_start_[k], static_cast<size_t>(of_stretch_start_[k + 1] - of_stretch_start_[k])};
  }
  bool sees(int64_t pose) const { return of_pose_start_[pose + 1] > of_pose_start_[pose]; }
  const std::vector<CameraChain>& chains() const { return chain_; }  // of each pose; none where there are no landmarks
  const FreeIntrinsics& intrinsics() const { return intrinsics_; }
  void shelve(Shelf& shelf) { shelf.add(of_pose_start_, of_stretch_start_, chain_); }

  void place_cameras();  // at the model's unknowns
  // Refreshes cameras at the model's unknowns, and views unless intrinsics are free: then linearise_with_intrinsics() does.
  void linearise();
  // Robustified cost of stereo and mono at the model's unknowns. Not finite: the point cannot be evaluated.
  std::array<double, 2> cost();
  // Information of observations on the intrinsics alone.
  struct OfIntrinsics {
    explicit OfIntrinsics(int width)
        : own(Eigen::MatrixXd::Zero(width, width)),
          gradient(Eigen::VectorXd::Zero(width)),
          modes{LensSquare::Zero(), LensSquare::Zero()} {}
    Eigen::MatrixXd own;  // lower half, but for the squares of lenses
    Eigen::VectorXd gradient;
    using LensSquare = Eigen::Matrix<double, kLensModes, kLensModes>;
    std::array<LensSquare, 2> modes;  // of top and bottom lens, the same of either axis of the image
  };
  // Adds the information of a view's observations between displacement and intrinsics, (3, width).
  void add_intrinsics(int64_t view, WithIntrinsics& cross) const;
  // The same, and by intrinsics alone, and refreshes the view: each observation is looked at once.
  void linearise_with_intrinsics(int64_t view, WithIntrinsics& cross, OfIntrinsics& alone);
  // Puts the squares of lenses into `own`.
  void put_lenses(OfIntrinsics& alone) const;

 private:
  struct Cameras;
  template <class Each>
  void add_intrinsics(int64_t view, WithIntrinsics& cross, OfIntrinsics* alone, const Each& each) const;
  void sort_landmarks();
  void sort_views();
  // Views by groups of so many poses, in their order, and where each group's begin.
  void group_views(int64_t poses, std::vector<int32_t>& start, std::pmr::vector<int32_t>& grouped) const;
  int64_t views() const { return static_cast<int64_t>(view_.size()) - 1; }
  // An observation is a row of stereo, or rows of stereo + a row of mono.
  int32_t pose_of(int32_t observation) const;
  int32_t landmark_of(int32_t observation) const;

  const Model& model_;
  FreeIntrinsics intrinsics_;
  std::pmr::vector<int32_t> order_, rank_, view_start_, observation_;
  std::pmr::vector<View> view_;  // and one more, where the observations of the last one end
  std::vector<int32_t> of_pose_start_, of_stretch_start_;
  std::pmr::vector<int32_t> of_pose_, of_stretch_;
  std::vector<CameraChain> chain_;
  std::shared_ptr<const Cameras> cameras_;  // where the poses' chains were placed
};

}  // namespace hullrecon
