// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Residuals of ranges and landmarks against the CAD model, and of the deviation field's prior.
#pragma once

#include "factors/residual.h"

namespace hullrecon {

// A DVL beam through the frames, from the DVL to M: `end` is the point at `length` along it, `along` its direction.
struct Beam {
  Mat3 tray;
  Vec3 end_dvl, end_tray, end_vehicle, end_hull, along_tray, along_vehicle, along_hull;

  Beam(const double* const* x, const Motion& offset, double tray_offset, const Vec3& tray_origin, const Vec3& beam,
       double length) {
    const Motion pose(x[0]), hull(x[1]), mount(x[2]);
    tray = rotation_y(x[0][7] + tray_offset);
    end_dvl = length * beam, end_tray = mount.apply(end_dvl), along_tray = mount.q * beam;
    end_vehicle = offset.apply(tray * end_tray + tray_origin), along_vehicle = offset.q * (tray * along_tray);
    end_hull = hull.to_child(pose.apply(end_vehicle)), along_hull = hull.q.conjugate() * (pose.q * along_vehicle);
  }
};

// Range of a DVL beam [Ozog2016 4.14].
// Rows: 1, m. Blocks: pose, T_g_M, T_s_d, field nodes. Frames: `offset` is the vehicle at the ping in the vehicle of the node.
// Sign: predicted - measured; predicted is the range along the beam to the plane of the triangle that it hits, moved outward by
// the field f: cast + f / (n . d), n the outward normal, d the beam (n . d = -cos(incidence) from outside). Sigma: one a beam.
// A miss has no residual and no derivative. Returns false where *refused (association.h): too many beams were lost at this
// point.
struct Range {
  static constexpr int kRows = 1;
  Motion offset;
  double tray_offset;
  Vec3 beam, tray_origin;  // unit, in d; in v
  double measured;
  FieldAt field;
  const Facet* facet;
  const bool* refused;

  std::vector<int> sizes() const { return field.sizes_after({8, 7, 7}); }
  Beam at(const double* const* x, double length) const { return Beam(x, offset, tray_offset, tray_origin, beam, length); }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const bool on = facet->active;
    const Beam start = at(x, 0);
    const double slope = on ? facet->normal.dot(start.along_hull) : 1.0, f = field.value(x + 3);
    const double cast = -(facet->normal.dot(start.end_hull) + facet->offset) / slope;
    r[0] = on ? cast + f / slope - measured : 0.0;
    if (!J) return !*refused;
    // dr = -n . d(end) / slope - f n . d(along) / slope^2; a turn moves both at once, hence the moment.
    const Beam b = at(x, cast);
    const auto moment = [&](const Vec3& end, const Vec3& along) { return Vec3(-end / slope - f / (slope * slope) * along); };
    const Vec3 n_global = Motion(x[1]).q * facet->normal, n_vehicle = Motion(x[0]).q.conjugate() * n_global;
    const Vec3 n_tray = b.tray.transpose() * (offset.q.conjugate() * n_vehicle), n_dvl = Motion(x[2]).q.conjugate() * n_tray;
    derive(J, 0, 1, 8, [&](Jacobian& j) {
      j << -n_global.transpose() / slope, moment(b.end_vehicle, b.along_vehicle).cross(n_vehicle).transpose(),
          n_tray.dot(turn_y(moment(b.end_tray, b.along_tray))), 0;
    });
    derive(J, 1, 1, 7, [&](Jacobian& j) {
      j << n_global.transpose() / slope, facet->normal.cross(moment(b.end_hull, b.along_hull)).transpose(), 0;
    });
    derive(J, 2, 1, 7,
           [&](Jacobian& j) { j << -n_tray.transpose() / slope, moment(b.end_dvl, beam).cross(n_dvl).transpose(), 0; });
    field.derive_nodes(J, 3, on ? 1 / slope : 0.0);
    return !*refused;
  }
};

// Distance of a landmark to the hull [Ozog2016 4.4, 4.5].
// Rows: 1, m. Blocks: landmark, T_g_M, field nodes. Frame: M. Sign: signed distance of T_g_M^-1 l to the CAD model, positive
// outside, less the field. Sigma: sigma_on, under the mixture's loss. The derivative is that of the true distance: `facet` is
// its tangent plane at the last refresh.
struct Surface {
  static constexpr int kRows = 1;
  FieldAt field;
  const Facet* facet;

  std::vector<int> sizes() const { return field.sizes_after({3, 7}); }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const Motion hull(x[1]);
    const Vec3 in_hull = hull.to_child(Eigen::Map<const Vec3>(x[0])), n_global = hull.q * facet->normal;
    r[0] = facet->normal.dot(in_hull) + facet->offset - field.value(x + 2);
    derive(J, 0, 1, 3, [&](Jacobian& j) { j.block<1, 3>(0, 0) = n_global.transpose(); });
    derive(J, 1, 1, 7, [&](Jacobian& j) {
      j.block<1, 3>(0, 0) = -n_global.transpose();
      j.block<1, 3>(0, 3) = facet->normal.cross(in_hull).transpose();
    });
    field.derive_nodes(J, 2, -1.0);
    return true;
  }
};

// Prior of the deviation field [RasmussenWilliams2006].
// Rows: 1, no unit: a row of the field's whitening operator times its nodes. Blocks: nodes. Sigma: within the operator.
struct FieldPrior {
  static constexpr int kRows = 1;
  FieldAt row;

  std::vector<int> sizes() const { return row.sizes_after({}); }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    r[0] = row.value(x);
    row.derive_nodes(J, 0, 1.0);
    return true;
  }
};

}  // namespace hullrecon
