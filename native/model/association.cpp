// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "model/association.h"

namespace hullrecon {

Association::Association(std::shared_ptr<const MeshIndex> mesh, int64_t surface_rows, int64_t range_rows, int threads)
    : mesh_(std::move(mesh)),
      threads_(threads),
      surface_(surface_rows),
      range_(range_rows),
      distance_(surface_rows),
      last_face_(surface_rows, -1),
      hit_(range_rows),
      was_hit_(range_rows),
      flickers_(range_rows) {}

void Association::place(int64_t row, const Vec3& point, int32_t hint) {
  const Closest c = mesh_->closest(point, hint);
  last_face_[row] = c.face;
  distance_[row] = c.distance;
  surface_[row] = {c.gradient, c.distance - c.gradient.dot(point), true};
}

void Association::shoot(int64_t row, const std::pair<Vec3, Vec3>& ray) {
  const Hit h = mesh_->cast(ray.first, ray.second);
  hit_[row] = h.face >= 0 && std::abs(h.normal.dot(ray.second)) > kGrazing;
  range_[row] = hit_[row] ? Facet{h.normal, -h.normal.dot(ray.first + h.range * ray.second), true} : Facet{};
}

void Association::settle(bool trial) {
  missed_ = 0;
  for (size_t i = 0; i < range_.size(); ++i) {
    if (!first_ && hit_[i] != was_hit_[i] && flickers_[i] <= kFlickers) ++flickers_[i];
    was_hit_[i] = hit_[i];
    if (flickers_[i] > kFlickers) range_[i] = Facet{};
    missed_ += !hit_[i];
  }
  refused_ = trial && !first_ && beams().loses_too_many();
  if (first_) accepted_misses_ = missed_;
  first_ = false;
}

void Association::accept() {
  accepted_misses_ = missed_;
}

}  // namespace hullrecon
