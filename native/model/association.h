// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Finds the closest triangle of each landmark and the triangle that each beam hits: refreshed at every new point, held in
// between.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/shelf.h"
#include "factors/residual.h"
#include "mesh/mesh_index.h"

namespace hullrecon {

class Association {
 public:
  Association(std::shared_ptr<const MeshIndex> mesh, int64_t surface_rows, int64_t range_rows, int threads);

  const Facet* surface(int64_t row) const { return &surface_[row]; }
  const Facet* range(int64_t row) const { return &range_[row]; }
  const bool* refused() const { return &refused_; }

  // point(i): landmark of surface row i in M.
  template <class Point>
  void refresh_surface(const Point& point);

  // ray(i): origin and unit direction in M of range row i. Misses switch a beam off. A beam that changes between hit and miss
  // more than kFlickers times is held off, for its cost would jump for ever. With `trial`, losing more than four beams and a
  // fifth of those that hit at the last accepted point refuses the point: a lost beam costs nothing, so turning the DVL away
  // from the hull would lower the cost.
  template <class Ray>
  void refresh_range(const Ray& ray, bool trial);
  void accept();  // the present point is the new one to compare with

  // How many beams miss at the present point, missed at the last accepted one, and are in the table.
  struct Beams {
    int64_t missed = 0, accepted_misses = 0, count = 0;
    // Whether so many more beams miss than at the last accepted point that this point is refused.
    bool loses_too_many() const { return missed - accepted_misses > std::max<int64_t>(4, (count - accepted_misses) / 5); }
  };
  Beams beams() const { return {missed_, accepted_misses_, static_cast<int64_t>(range_.size())}; }
  void refuse(bool refused) { refused_ = refused; }  // the point, for the beams of all parts of a problem

  void shelve(Shelf& shelf) { shelf.add(surface_, range_, distance_, last_face_, hit_, was_hit_, flickers_); }

  int64_t missed() const { return missed_; }
  const std::vector<double>& distance() const { return distance_; }  // m, signed, of each surface row, without the field
  bool hit(int64_t row) const { return hit_[row]; }

 private:
  static constexpr int kFlickers = 3;
  static constexpr double kGrazing = 0.02;  // |cos(incidence)|; flatter, the range's derivative means nothing

  void place(int64_t row, const Vec3& point, int32_t hint);
  void shoot(int64_t row, const std::pair<Vec3, Vec3>& ray);
  void settle(bool trial);

  std::shared_ptr<const MeshIndex> mesh_;
  int threads_;
  std::vector<Facet> surface_, range_;
  std::vector<double> distance_;
  std::vector<int32_t> last_face_;
  std::vector<char> hit_, was_hit_, flickers_;
  bool first_ = true, refused_ = false;
  int64_t missed_ = 0, accepted_misses_ = 0;
};

}  // namespace hullrecon

#include "common/parallel.h"

namespace hullrecon {

// The face of last time is near the one of now; at the first time that of the row before is: rows come as the hull was seen.
template <class Point>
void Association::refresh_surface(const Point& point) {
  for_slabs(static_cast<int64_t>(surface_.size()), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i)
      place(i, point(i), last_face_[i] >= 0 || i == begin ? last_face_[i] : last_face_[i - 1]);
  });
}

template <class Ray>
void Association::refresh_range(const Ray& ray, bool trial) {
  for_slabs(static_cast<int64_t>(range_.size()), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) shoot(i, ray(i));
  });
  settle(trial);
}

}  // namespace hullrecon
