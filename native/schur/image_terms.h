// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Stereo and mono factors by landmark, for the specialised core: ordered once, evaluated without virtual calls.
#pragma once

#include <array>
#include <vector>

#include "model/model.h"
#include "schur/camera_chain.h"

namespace hullrecon {

// All that the images at one pose say of one landmark: information and gradient (both robustified) by its apparent displacement
// in g. Six numbers of the symmetric matrix: xx xy xz yy yz zz.
struct View {
  std::array<double, 6> information;
  Vec3 gradient;
  int32_t pose, landmark;  // by rank
  int32_t first_sight;

  Mat3 matrix() const {
    const auto& h = information;
    Mat3 m;
    m << h[0], h[1], h[2], h[1], h[3], h[4], h[2], h[4], h[5];
    return m;
  }
};

// Optics: T_ct_cb and the two lenses, those that are free, side by side. Few dives free them, so they take the slow lane.
class Optics {
 public:
  explicit Optics(const Model& model);
  int width() const { return width_; }
  int bottom() const { return at_[0]; }  // first column; -1: held
  int lens(bool below) const { return at_[1 + below]; }

 private:
  std::array<int, 3> at_;
  int width_ = 0;
};

class Sights {
 public:
  explicit Sights(const Model& model);

  // Landmarks by rank: those first seen from one pose stand together, so that neighbours in memory are neighbours on the hull.
  int32_t landmark(int64_t rank) const { return order_[rank]; }
  int64_t rank(int64_t landmark) const { return rank_[landmark]; }
  int32_t first_view(int64_t rank) const { return view_start_[rank]; }
  int64_t views() const { return static_cast<int64_t>(view_.size()) - 1; }
  const View& view(int64_t i) const { return view_[i]; }
  const std::vector<Arm>& arms() const { return arm_; }
  const Optics& optics() const { return optics_; }

  void place_arms();  // at the model's unknowns
  // Refreshes the arms, then views and, per kind, cost (stereo, mono) at the model's unknowns.
  void linearise();
  // Robustified cost of stereo and mono at the model's unknowns. Not finite: the point cannot be evaluated.
  std::array<double, 2> cost();
  // Of the sights of a view, by apparent displacement and optics: (3, width), and by optics alone, added.
  void by_optics(int64_t view, Eigen::Matrix3Xd& cross, Eigen::MatrixXd* own, Eigen::VectorXd* gradient) const;

 private:
  struct Eyes;
  void sort();

  const Model& model_;
  Optics optics_;
  std::vector<int32_t> order_, rank_, view_start_, sight_;  // sight: row of stereo, or rows of stereo + row of mono
  std::vector<View> view_;                                  // and one more, where the last one's sights end
  std::vector<Arm> arm_;
};

}  // namespace hullrecon
