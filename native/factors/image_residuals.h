// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Residuals of stereo pairs and single images.
#pragma once

#include "factors/camera.h"
#include "factors/lens.h"
#include "factors/residual.h"

namespace hullrecon {

// A landmark in the top camera's frame, T_g_v Trans(tray_origin) Ry(theta) T_s_ct, with its derivatives.
struct InTopCamera {
  Vec3 point;
  Mat3 by_landmark;
  Eigen::Matrix<double, 3, 7> by_pose;
  Eigen::Matrix<double, 3, 6> by_mount;

  InTopCamera(const double* landmark, const double* pose_block, const double* mount_block, const Vec3& tray_origin,
              bool derive) {
    const Motion pose(pose_block), mount(mount_block);
    const Mat3 tray_from_vehicle = rotation_y(-pose_block[7]), camera_from_tray = mount.rotation().transpose();
    const Vec3 in_vehicle = pose.to_child(Eigen::Map<const Vec3>(landmark)),
               in_tray = tray_from_vehicle * (in_vehicle - tray_origin);
    point = camera_from_tray * (in_tray - mount.t);
    if (!derive) return;
    const Mat3 camera_from_vehicle = camera_from_tray * tray_from_vehicle;
    by_landmark = camera_from_vehicle * pose.rotation().transpose();
    by_pose << -by_landmark, camera_from_vehicle * hat(in_vehicle), -camera_from_tray * turn_y(in_tray);
    by_mount << -camera_from_tray, hat(point);
  }
};

// A stereo pair [Ozog2016 4.12].
// Rows: 4, px: top u v, bottom u v, raw pixels through the full camera model. Blocks: landmark, pose, T_s_ct, T_ct_cb,
// intrinsics of top and bottom and, with image_size, lenses of top and bottom. Sign: predicted - measured. Sigma: one for all
// rows; one Huber loss on the norm of the four, as a wrong match spoils the whole pair (Options.huber_stereo). A point behind a
// camera: kBehindPixels, no derivative (camera.h).
struct Stereo {
  static constexpr int kRows = 4;
  Vec3 tray_origin;
  Eigen::Vector4d measured;
  const double* image_size = nullptr;  // (2, 2) of top and bottom; null: lenses have no displacement

  std::vector<int> sizes() const {
    return image_size ? std::vector{3, 8, 7, 7, 9, 9, kLensNumbers, kLensNumbers} : std::vector{3, 8, 7, 7, 9, 9};
  }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const InTopCamera top(x[0], x[1], x[2], tray_origin, J != nullptr);
    const Motion bottom_pose(x[3]);
    const Vec3 in_bottom = bottom_pose.to_child(top.point);
    Projection above, below;
    const bool seen = project(x[4], top.point, J, above) && project(x[5], in_bottom, J, below);
    Eigen::Map<Eigen::Vector4d> out(r);
    if (seen) out << above.pixel - measured.head<2>(), below.pixel - measured.tail<2>();
    for (int k = 0; seen && image_size && k < 2; ++k) out.segment<2>(2 * k) -= displacement_px(x[6 + k], modes(k));
    if (!seen) out.setConstant(kBehindPixels);
    if (!J) return true;
    if (!seen) above.by_point.setZero(), below.by_point.setZero();
    const Mat3 bottom_from_top = bottom_pose.rotation().transpose();
    Eigen::Matrix<double, 4, 3> by_top;  // by the point in the top camera
    by_top << above.by_point, below.by_point * bottom_from_top;
    derive(J, 0, 4, 3, [&](Jacobian& j) { j.block<4, 3>(0, 0) = by_top * top.by_landmark; });
    derive(J, 1, 4, 8, [&](Jacobian& j) { j.block<4, 7>(0, 0) = by_top * top.by_pose; });
    derive(J, 2, 4, 7, [&](Jacobian& j) { j.block<4, 6>(0, 0) = by_top * top.by_mount; });
    derive(J, 3, 4, 7, [&](Jacobian& j) {
      j.block<2, 3>(2, 0) = -below.by_point * bottom_from_top;
      j.block<2, 3>(2, 3) = below.by_point * hat(in_bottom);
    });
    derive(J, 4, 4, 9, [&](Jacobian& j) {
      if (seen) j.block<2, 9>(0, 0) = by_intrinsics(x[4], top.point);
    });
    derive(J, 5, 4, 9, [&](Jacobian& j) {
      if (seen) j.block<2, 9>(2, 0) = by_intrinsics(x[5], in_bottom);
    });
    for (int k = 0; image_size && k < 2; ++k) {
      derive(J, 6 + k, 4, kLensNumbers, [&](Jacobian& j) {
        if (seen) put_by_lens(j, 2 * k, modes(k));
      });
    }
    return true;
  }

 private:
  LensModes modes(int camera) const { return lens_modes(image_size + 2 * camera, measured.data() + 2 * camera); }
};

// One image of a landmark [Ozog2016 4.13].
// Rows: 2, px: u v. Blocks: landmark, pose, T_s_ct, intrinsics of that camera and, for the bottom one, T_ct_cb, and with
// image_size its lens. Sign: predicted - measured. Sigma: one; Huber loss on the norm of both rows (Options.huber_mono).
struct Mono {
  static constexpr int kRows = 2;
  Vec3 tray_origin;
  Eigen::Vector2d measured;
  bool bottom;
  const double* image_size = nullptr;  // (2,) of this camera; null: its lens has no displacement

  std::vector<int> sizes() const {
    std::vector out{3, 8, 7, 9};
    if (bottom) out.push_back(7);
    if (image_size) out.push_back(kLensNumbers);
    return out;
  }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const InTopCamera top(x[0], x[1], x[2], tray_origin, J != nullptr);
    const Motion camera = bottom ? Motion(x[4]) : Motion(Vec3::Zero(), Quaternion::Identity());
    const Vec3 point = camera.to_child(top.point);
    Projection image;
    const bool seen = project(x[3], point, J, image);
    Eigen::Map<Eigen::Vector2d> out(r);
    if (seen) out = image.pixel - measured;
    const int lens = bottom ? 5 : 4;
    const LensModes modes = image_size ? lens_modes(image_size, measured.data()) : LensModes();
    if (seen && image_size) out -= displacement_px(x[lens], modes);
    if (!seen) out.setConstant(kBehindPixels);
    if (!J) return true;
    if (!seen) image.by_point.setZero();
    const Eigen::Matrix<double, 2, 3> by_top = image.by_point * camera.rotation().transpose();
    derive(J, 0, 2, 3, [&](Jacobian& j) { j.block<2, 3>(0, 0) = by_top * top.by_landmark; });
    derive(J, 1, 2, 8, [&](Jacobian& j) { j.block<2, 7>(0, 0) = by_top * top.by_pose; });
    derive(J, 2, 2, 7, [&](Jacobian& j) { j.block<2, 6>(0, 0) = by_top * top.by_mount; });
    derive(J, 3, 2, 9, [&](Jacobian& j) {
      if (seen) j.block<2, 9>(0, 0) = by_intrinsics(x[3], point);
    });
    if (bottom) derive(J, 4, 2, 7, [&](Jacobian& j) { j.block<2, 6>(0, 0) << -by_top, image.by_point * hat(point); });
    if (!image_size) return true;
    derive(J, lens, 2, kLensNumbers, [&](Jacobian& j) {
      if (seen) put_by_lens(j, 0, modes);
    });
    return true;
  }
};

}  // namespace hullrecon
