// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Residuals of links: the relative pose of two cameras, from a pair of images [KimEustice2009 II-B].
#pragma once

#include <algorithm>
#include <array>

#include "factors/residual.h"

namespace hullrecon {

// A camera of the tray in g, T_g_v Trans(tray_origin) Ry(theta) T_s_ct and, for the bottom one, T_ct_cb, with its derivatives.
// Rows of these: the centre in the axes of g, the rotation perturbed on the right (in the axes of the camera).
struct CameraPose {
  Vec3 centre;
  Quaternion q;
  Eigen::Matrix<double, 6, 7> by_pose;
  Eigen::Matrix<double, 6, 6> by_mount, by_bottom;

  // bottom_block: null of the top camera.
  CameraPose(const double* pose_block, const double* mount_block, const double* bottom_block, const Vec3& tray_origin,
             bool derive) {
    const Motion pose(pose_block), mount(mount_block);
    const Motion bottom = bottom_block ? Motion(bottom_block) : Motion(Vec3::Zero(), Quaternion::Identity());
    const Quaternion from_tray = pose.q * Eigen::AngleAxisd(pose_block[7], Vec3::UnitY()), from_top = from_tray * mount.q;
    const Vec3 in_tray = mount.apply(bottom.t), in_vehicle = tray_origin + rotation_y(pose_block[7]) * in_tray;
    centre = pose.apply(in_vehicle);
    q = from_top * bottom.q;
    if (!derive) return;
    const Mat3 camera_from_vehicle = (q.conjugate() * pose.q).toRotationMatrix();
    by_pose.setZero(), by_mount.setZero(), by_bottom.setZero();
    by_pose.topLeftCorner<3, 3>().setIdentity();
    by_pose.block<3, 3>(0, 3) = -pose.rotation() * hat(in_vehicle);
    by_pose.block<3, 3>(3, 3) = camera_from_vehicle;
    by_pose.col(6) << from_tray * turn_y(in_tray), camera_from_vehicle.col(1);
    by_mount.topLeftCorner<3, 3>() = from_tray.toRotationMatrix();
    by_mount.topRightCorner<3, 3>() = -from_top.toRotationMatrix() * hat(bottom.t);
    by_mount.bottomRightCorner<3, 3>() = bottom.rotation().transpose();
    by_bottom.topLeftCorner<3, 3>() = from_top.toRotationMatrix();
    by_bottom.bottomRightCorner<3, 3>().setIdentity();
  }
};

// Two cameras, the second seen from the first: T = T_g_c1^-1 T_g_c2. Blocks of every link: pose of the first, pose of the
// second, T_s_ct and, where one of the cameras is the bottom one, T_ct_cb.
struct CameraPair {
  Vec3 tray_origin;
  Motion measured;  // first_from_second; of a bearing its translation's length means nothing
  bool first_bottom, second_bottom;

  bool meets_bottom() const { return first_bottom || second_bottom; }
  std::vector<int> sizes() const { return meets_bottom() ? std::vector{8, 8, 7, 7} : std::vector{8, 8, 7}; }

  // What is predicted: translation in the axes of the first camera, rotation less the measured one, Log(R_z' R).
  struct Predicted {
    CameraPose first, second;
    Vec3 translation, turn;
  };
  Predicted at(const double* const* x, bool derive) const {
    Predicted p{{x[0], x[2], first_bottom ? x[3] : nullptr, tray_origin, derive},
                {x[1], x[2], second_bottom ? x[3] : nullptr, tray_origin, derive},
                {},
                {}};
    p.translation = p.first.q.conjugate() * (p.second.centre - p.first.centre);
    p.turn = log(measured.q.conjugate() * p.first.q.conjugate() * p.second.q);
    return p;
  }

  // Writes J of Rows rows, by_translation (Rows - 3, 3) being the derivative of the first of them by the translation.
  template <int Rows>
  void derive_blocks(const Predicted& p, const Eigen::Matrix<double, Rows - 3, 3>& by_translation, double* const* J) const {
    if (!J) return;
    using ByCamera = Eigen::Matrix<double, Rows, 6>;
    const Mat3 from_global = p.first.q.conjugate().toRotationMatrix(), by_turn = log_derivative(p.turn);
    ByCamera by_first = ByCamera::Zero(), by_second = ByCamera::Zero();
    by_first.template topLeftCorner<Rows - 3, 3>() = -by_translation * from_global;
    by_first.template topRightCorner<Rows - 3, 3>() = by_translation * hat(p.translation);
    by_first.template bottomRightCorner<3, 3>() = -by_turn * (p.second.q.conjugate() * p.first.q).toRotationMatrix();
    by_second.template topLeftCorner<Rows - 3, 3>() = by_translation * from_global;
    by_second.template bottomRightCorner<3, 3>() = by_turn;
    derive(J, 0, Rows, 8, [&](Jacobian& j) { j.block<Rows, 7>(0, 0) = by_first * p.first.by_pose; });
    derive(J, 1, Rows, 8, [&](Jacobian& j) { j.block<Rows, 7>(0, 0) = by_second * p.second.by_pose; });
    derive(J, 2, Rows, 7,
           [&](Jacobian& j) { j.block<Rows, 6>(0, 0) = by_first * p.first.by_mount + by_second * p.second.by_mount; });
    if (!meets_bottom()) return;
    derive(J, 3, Rows, 7, [&](Jacobian& j) {
      if (first_bottom) j.block<Rows, 6>(0, 0) += by_first * p.first.by_bottom;
      if (second_bottom) j.block<Rows, 6>(0, 0) += by_second * p.second.by_bottom;
    });
  }
};

// A link with length: of a stereo rig [Ozog2016 D.2.3].
// Rows: 6, (m, rad). Frame: translation in the axes of the first camera, rotation in those of the measured second one.
// Sign: predicted - measured, [t - t_z ; Log(R_z' R)]. Sigma: full square root of the information.
struct ScaledLink {
  static constexpr int kRows = 6;
  CameraPair pair;

  std::vector<int> sizes() const { return pair.sizes(); }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const CameraPair::Predicted p = pair.at(x, J != nullptr);
    Eigen::Map<Eigen::Matrix<double, 6, 1>>(r) << p.translation - pair.measured.t, p.turn;
    pair.derive_blocks<6>(p, Mat3::Identity(), J);
    return true;
  }
};

// Two unit vectors across a direction, the axes in which a bearing is given: b1 across the direction and the axis of g that it
// leans to least (the first of equals), b2 = direction x b1.
inline Eigen::Matrix<double, 3, 2> bearing_basis(const Vec3& direction) {
  int least = 0;
  direction.cwiseAbs().minCoeff(&least);
  const Vec3 z = direction.normalized(), b1 = z.cross(Vec3::Unit(least)).normalized();
  Eigen::Matrix<double, 3, 2> basis;
  basis << b1, z.cross(b1);
  return basis;
}

// A link whose length is unknown, as a single camera measures it: five degrees of freedom [KimEustice2009 II-B].
// Rows: 5, rad: the predicted direction to the second camera about the measured one (angle times the tangent towards it, in the
// axes of bearing_basis), then rotation as ScaledLink. Sign: predicted - measured. Sigma: full square root of the information.
// Cameras in one place have no direction, opposite ones no tangent: both rows are then pi, without derivative, as of a point
// behind a camera.
struct BearingLink {
  static constexpr int kRows = 5;
  static constexpr double kOnePlace = 1e-9;  // m, or rad from the opposite direction
  CameraPair pair;

  std::vector<int> sizes() const { return pair.sizes(); }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const CameraPair::Predicted p = pair.at(x, J != nullptr);
    const Eigen::Matrix<double, 2, 3> across = bearing_basis(pair.measured.t).transpose();
    const Vec3 z = pair.measured.t.normalized(), u = p.translation.normalized();
    const double length = p.translation.norm(), c = z.dot(u);
    const Eigen::Vector2d off = across * u;
    const double s = off.norm(), by_sine = s > 1e-4 || c < 0 ? std::atan2(s, c) / s : 1 + s * s / 6;
    const bool seen = length > kOnePlace && (c > 0 || s > kOnePlace);
    Eigen::Map<Eigen::Matrix<double, 5, 1>> out(r);
    out << by_sine * off, p.turn;
    if (!seen) out.head<2>().setConstant(M_PI);
    if (!J) return true;
    const double curl = s > 3e-3 || c < 0 ? (c - by_sine) / (s * s) : -2.0 / 3 - s * s / 5;
    Eigen::Matrix<double, 2, 3> by_translation = by_sine * across + off * (curl * off.transpose() * across - z.transpose());
    by_translation = (by_translation * (Mat3::Identity() - u * u.transpose()) / length).eval();
    if (!seen) by_translation.setZero();
    pair.derive_blocks<5>(p, by_translation, J);
    return true;
  }
};

// A link behind a switch that the solver may open [SunderhaufProtzel2012].
// Rows: those of the link times the switch, and the switch's prior, switch - 1. Blocks: those of the link, the switch (1).
// Sigma: that of the link, and one over the square root of Phi.
template <class Link>
struct SwitchedLink {
  static constexpr int kRows = Link::kRows + 1;
  Link link;

  std::vector<int> sizes() const {
    std::vector<int> out = link.sizes();
    out.push_back(1);
    return out;
  }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const std::vector<int> of_link = link.sizes();
    const size_t at = of_link.size();
    const double on = x[at][0];
    std::array<Eigen::Matrix<double, Link::kRows, 8, Eigen::RowMajor>, 4> raw;
    std::array<double*, 4> into{};
    for (size_t k = 0; J && k < at; ++k) into[k] = J[k] ? raw[k].data() : nullptr;
    if (!link(x, r, J ? into.data() : nullptr)) return false;
    Eigen::Map<Eigen::Matrix<double, Link::kRows, 1>> of_rows(r);
    for (size_t k = 0; J && k < at; ++k) {
      if (!J[k]) continue;
      const int size = of_link[k];
      for (int n = 0; n < Link::kRows * size; ++n) J[k][n] = on * raw[k].data()[n];
      std::fill_n(J[k] + Link::kRows * size, size, 0.0);
    }
    if (J && J[at]) std::copy_n(r, Link::kRows, J[at]), J[at][Link::kRows] = 1;
    of_rows *= on;
    r[Link::kRows] = on - 1;
    return true;
  }
};

}  // namespace hullrecon
