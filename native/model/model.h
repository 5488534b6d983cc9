// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Turns tables into unknowns and factors: what solve, evaluate and covariance share. Nothing of Ceres here.
#pragma once

#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/shelf.h"
#include "factors/lens.h"
#include "factors/mixture.h"
#include "model/association.h"
#include "model/field_nodes.h"
#include "model/tables.h"

namespace hullrecon {

enum class Kind : int8_t {
  Prior,
  Attitude,
  Tray,
  Odometry,
  Stereo,
  Mono,
  Range,
  Surface,
  Deviation,
  Link,
  Plane,
  PlanePair,
  PlaneRange,
  Velocity,
  Position
};
constexpr int kMostRows = kLensNumbers;  // of a residual: the prior of a lens
constexpr std::array<const char*, 15> kKindNames{"prior", "attitude",   "tray",        "odometry",  "stereo",
                                                 "mono",  "range",      "surface",     "deviation", "link",
                                                 "plane", "plane_pair", "plane_range", "velocity",  "position"};

// Blocks that every factor may meet, in this order after poses and landmarks.
enum Global {
  kHull,
  kCamera,
  kBottom,
  kDvl,
  kNavigation,
  kTopIntrinsics,
  kBottomIntrinsics,
  kWorld,
  kTopLens,
  kBottomLens,
  kGlobals
};

// One block of unknowns. tangent: its columns; 0 when held.
struct Block {
  double* data;
  int size, tangent;
  int64_t column;  // of its first tangent coordinate; -1 when held
};

struct Range;  // factors/hull_residuals.h

// The CAD model of tables with factors that depend on it; null without.
std::shared_ptr<const MeshIndex> index_mesh(const Tables& tables);

class Model {
 public:
  // mesh: of the CAD model, as index_mesh makes it; null: made here.
  // pages: memory for what grows with the tables, from which it is removed at rest. null: ordinary memory.
  Model(const Tables& tables, const Options& options, std::shared_ptr<const MeshIndex> mesh = nullptr,
        std::pmr::memory_resource* pages = nullptr);

  // A model at rest knows its tables and unknowns alone.
  void rest() { shelf_.put(); }
  void wake() { shelf_.take(); }

  // Blocks in the order of columns: poses, landmarks, T_g_M, T_s_ct, T_ct_cb, T_s_d, navigation, intrinsics_top,
  // intrinsics_bottom, world, lens_top, lens_bottom, nodes of the deviation field, planes, switches of links.
  const std::vector<Block>& blocks() const { return blocks_; }
  std::string name_of(int block) const;  // "pose 0", "T_g_M"

  // Factors are numbered by kind, then by row. Their residuals are made when they are evaluated: half a million kept would cost
  // 300 MB.
  int64_t factors() const { return first_.back(); }
  std::pair<int64_t, int64_t> factors_of(Kind kind) const;  // first, end
  Kind kind_of(int64_t factor) const;
  int64_t row_of(int64_t factor) const;  // in its table
  void blocks_of(int64_t factor, std::vector<int32_t>& blocks) const;
  int rows_of(int64_t factor) const;  // of its residual
  // Evaluates a factor's residual (factors/residual.h) at the blocks x and whitens it. sizes: of the blocks; J may be null.
  bool evaluate(int64_t factor, std::span<const int> sizes, const double* const* x, double* r, double* const* J) const;
  Robust robust(int64_t factor) const;  // its loss, of the whitened residual squared

  int64_t poses() const { return tables_.pose.rows(); }
  int64_t landmarks() const { return tables_.landmark.rows(); }
  int64_t columns() const { return columns_; }
  int block(const char* name) const;  // a global block by name
  bool is_landmark(int32_t block) const { return block >= poses() && block < poses() + landmarks(); }
  int first_node() const { return static_cast<int>(poses() + landmarks() + kGlobals); }
  int nodes() const { return static_cast<int>(tables_.deviation.rows()); }
  int first_plane() const { return first_node() + nodes(); }
  int planes() const { return static_cast<int>(tables_.plane.rows()); }
  int first_switch() const { return first_plane() + planes(); }
  const Tables& tables() const { return tables_; }
  const Options& options() const { return options_; }
  const Mixture& mixture() const { return mixture_; }

  // Closest triangles and hits at the present unknowns. surface_too: of the surface rows even when no factor needs them.
  void refresh(bool trial, bool surface_too = false);
  Association& association() { return association_; }
  const Association& association() const { return association_; }

  Vec3 landmark(int64_t i) const { return Vec3(landmark_ + 3 * i); }
  std::vector<double>& unknowns() { return unknowns_; }  // every block's numbers
  MixtureLoss surface_loss(int64_t row) const;
  std::span<const int32_t> surface_nodes(int64_t row) const { return surface_nodes_.nodes(row); }
  FieldAt surface_field(int64_t row) const { return surface_nodes_.at(row); }

  // 1 on the hull, 0 off it, for each surface row at the last refresh: by the mixture, or as the method or the hold has it.
  std::vector<int32_t> labels() const;

  // Robustified cost by kind at the present unknowns and tables; the same number for any number of threads.
  std::array<double, kKindNames.size()> costs() const;

 private:
  void add_blocks();
  void add_block(double* data, int size, int tangent);
  void number_factors();
  void hold_labels();
  int64_t number_of(int64_t factor) const { return factor - first_[static_cast<size_t>(kind_of(factor))]; }  // in its kind
  // Call use(residual, whitening) with the factor's own types (model/factors.cpp).
  template <class Use>
  void visit(int64_t factor, Use& use) const;
  template <class Use>
  void visit_prior(int64_t row, Use& use) const;
  template <class Use>
  void visit_link(int64_t row, Use& use) const;
  Range range(int64_t row) const;
  std::pair<Vec3, Vec3> ray(int64_t row, const double* const* x) const;  // origin and direction in M of a beam

  Tables tables_;
  Options options_;
  Mixture mixture_;
  // All in one array: Ceres orders the blocks of an elimination group by their addresses, and those of separate arrays
  // change from process to process, and with them the last digits of the solution.
  std::vector<double> unknowns_;
  double *landmark_ = nullptr, *intrinsics_ = nullptr;  // in unknowns_
  std::vector<Block> blocks_;
  int64_t columns_ = 0;
  Association association_;
  NodeTable range_nodes_, surface_nodes_, prior_nodes_;
  std::vector<int> global_priors_;                  // of the blocks that have one and are free
  std::vector<int32_t> surface_rows_, field_rows_;  // that make factors
  std::vector<int32_t> switch_of_link_;             // -1: none
  std::array<double, 18> intrinsics_start_;
  std::array<int64_t, kKindNames.size() + 1> first_{};  // factor of each kind
  std::vector<int32_t> held_labels_;                    // empty: labels are free
  Shelf shelf_;
};

}  // namespace hullrecon
