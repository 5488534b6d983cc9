// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The Schur core against dense normal equations, whatever is held.
#include "schur/schur.h"

#include <functional>

#include "small_problem.h"
#include "solve/information.h"

#include "expect.h"

using namespace hullrecon;

namespace {

// A StepVector by the columns of the model.
Eigen::VectorXd by_columns(const Model& model, const Schur& schur, const StepVector& step) {
  Eigen::VectorXd out(model.columns());
  for (int b = 0; b < static_cast<int>(model.blocks().size()); ++b) {
    const Block& block = model.blocks()[b];
    if (block.tangent == 0) continue;
    const int64_t l = b - model.poses();
    if (l >= 0 && l < model.landmarks()) {
      out.segment(block.column, 3) = step.landmark.segment<3>(3 * schur.rank(l));
      continue;
    }
    const ReducedLayout& layout = schur.layout();
    const int at = layout.block_of(b);
    const int first = at < layout.blocks() ? schur.offset(at) : schur.offset(at) + layout.column(layout.global_of(b));
    out.segment(block.column, block.tangent) = step.reduced.segment(first, block.tangent);
  }
  return out;
}

StepVector constant(const Schur& schur, double value) {
  return {Eigen::VectorXd::Constant(schur.gradient().landmark.size(), value),
          Eigen::VectorXd::Constant(schur.gradient().reduced.size(), value)};
}

double largest(const Eigen::VectorXd& v) {
  return v.size() > 0 ? v.cwiseAbs().maxCoeff() : 0.0;
}

}  // namespace

TEST_CASE("gradient and diagonal are those of the dense normal equations, whatever is held") {
  for (const auto& held : held_sets()) {
    for (const char* method : {"naive", "geva", "maxmix"}) {
      SmallProblem problem(held);
      Options options;
      options.method = method;
      Model model(problem.tables, options);
      model.refresh(false);
      Schur schur(model);
      schur.linearise();
      const Dense dense(model);
      const Eigen::VectorXd gradient = by_columns(model, schur, schur.gradient());
      const Eigen::VectorXd diagonal = by_columns(model, schur, schur.diagonal()), expected = dense.information.diagonal();
      const Eigen::VectorXd unit = expected.cwiseSqrt().cwiseMax(1e-12);
      CHECK(largest((gradient - dense.gradient).cwiseQuotient(unit)) <
            1e-9 * (1 + largest(dense.gradient.cwiseQuotient(unit))));
      CHECK(largest((diagonal - expected).cwiseQuotient(expected.cwiseMax(1e-12))) < 1e-10);
    }
  }
}

TEST_CASE("a damped step solves the dense normal equations, whatever is held") {
  for (const auto& held : held_sets()) {
    for (double damping : {1e-3, 1.0, 1e6}) {
      SmallProblem problem(held);
      Model model(problem.tables, Options{});
      model.refresh(false);
      Schur schur(model);
      schur.linearise();
      StepVector step;
      REQUIRE(schur.step(constant(schur, damping), step));
      const Dense dense(model);
      const Eigen::VectorXd got = by_columns(model, schur, step);
      const Eigen::VectorXd rest = dense.information * got + damping * got + dense.gradient;
      const Eigen::VectorXd unit = dense.information.diagonal().cwiseSqrt().cwiseMax(1e-12);
      CHECK(largest(rest.cwiseQuotient(unit)) < 1e-8 * largest(dense.gradient.cwiseQuotient(unit)));
    }
  }
}

TEST_CASE("a step in halves is the whole one, whatever stays on the interface") {
  for (const auto& held : held_sets()) {
    SmallProblem problem(held);
    Model model(problem.tables, Options{});
    model.refresh(false);
    Schur whole(model);
    const int node = whole.layout().node(1);
    for (const std::vector<int>& interface : {std::vector<int>{}, {2}, {3, 0, 1}, {4, whole.layout().nodes() > 0 ? node : 0}}) {
      Schur part(model, interface);
      whole.linearise(), part.linearise();
      StepVector expected, step, damping = constant(part, 1.0);
      REQUIRE(whole.step(constant(whole, 1.0), expected));
      REQUIRE(part.condense(damping));
      const int outer = static_cast<int>(damping.reduced.size()) - part.interior();
      const Eigen::MatrixXd left = part.condensed().selfadjointView<Eigen::Lower>();
      step.reduced.resize(damping.reduced.size());
      step.reduced.tail(outer) = -left.ldlt().solve(Eigen::VectorXd(part.condensed_gradient()));
      REQUIRE(part.finish(step));
      const Eigen::VectorXd got = by_columns(model, part, step), want = by_columns(model, whole, expected);
      CHECK(largest(got - want) < 1e-9 * largest(want));
    }
  }
}

TEST_CASE("a second step from one point forgets the first, and threads change nothing") {
  std::vector<Eigen::VectorXd> steps;
  for (int threads : {1, 2, 5}) {
    SmallProblem problem;
    Options options;
    options.threads = threads;
    Model model(problem.tables, options);
    model.refresh(false);
    Schur schur(model);
    schur.linearise();
    StepVector first, second;
    REQUIRE(schur.step(constant(schur, 10.0), first));
    REQUIRE(schur.step(constant(schur, 1.0), first));
    REQUIRE(schur.step(constant(schur, 10.0), second));
    steps.push_back(by_columns(model, schur, second));
  }
  CHECK((steps[0].array() == steps[1].array()).all());
  CHECK((steps[0].array() == steps[2].array()).all());
}

TEST_CASE("a negative damping that makes the system indefinite is refused") {
  SmallProblem problem;
  Model model(problem.tables, Options{});
  model.refresh(false);
  Schur schur(model);
  schur.linearise();
  StepVector step, damping = constant(schur, 0.0);
  damping.landmark[4] = -1e12;
  CHECK_FALSE(schur.step(damping, step));
  damping = constant(schur, 1.0);
  damping.reduced[3] = -1e12;
  CHECK_FALSE(schur.step(damping, step));
}

TEST_CASE("costs by kind are those of the factors one by one") {
  for (const char* method : {"naive", "geva", "maxmix"}) {
    SmallProblem problem;
    Options options;
    options.method = method;
    Model model(problem.tables, options);
    model.refresh(false);
    Schur schur(model);
    const auto got = schur.cost();
    REQUIRE(got.has_value());
    std::array<double, kKindNames.size()> expected{};
    LinearFactor factor;
    for (int64_t f = 0; f < model.factors(); ++f) {
      factor.at(model, f);
      expected[static_cast<size_t>(model.kind_of(f))] += factor.cost;
    }
    const auto all = model.costs();
    for (size_t k = 0; k < expected.size(); ++k) {
      CHECK((*got)[k] == doctest::Approx(expected[k]).epsilon(1e-12));
      CHECK(all[k] == doctest::Approx(expected[k]).epsilon(1e-12));
    }
  }
}

TEST_CASE("a point that a factor cannot be evaluated at has no cost") {
  SmallProblem problem;
  Model model(problem.tables, Options{});
  model.refresh(false);
  Schur schur(model);
  double* const pose = model.blocks()[2].data;
  pose[3] = 0, pose[4] = std::sqrt(0.5), pose[5] = 0, pose[6] = std::sqrt(0.5);  // the bow straight down
  CHECK_FALSE(schur.cost().has_value());
}

TEST_CASE("plus moves every free block by its own part of the step and no held one") {
  for (const auto& held : held_sets()) {
    SmallProblem problem(held);
    Model model(problem.tables, Options{});
    Schur schur(model);
    StepVector step = constant(schur, 0.0);
    std::vector<double> to;
    schur.plus(model.unknowns(), step, to);
    for (size_t k = 0; k < to.size(); ++k) CHECK(to[k] == doctest::Approx(model.unknowns()[k]).epsilon(1e-15));
    for (double& x : step.landmark) x = 0.1 * problem.normal();
    for (double& x : step.reduced) x = 0.1 * problem.normal();
    schur.plus(model.unknowns(), step, to);
    const Eigen::VectorXd delta = by_columns(model, schur, step);
    const double *const first = model.unknowns().data(), *const last = first + model.unknowns().size();
    for (const Block& block : model.blocks()) {
      if (std::less<>()(block.data, first) || !std::less<>()(block.data, last)) {  // a world that is held: no part of the array
        CHECK(block.tangent == 0);
        continue;
      }
      const double* const moved = to.data() + (block.data - first);
      std::vector<double> expected(block.data, block.data + block.size);
      if (block.tangent > 0) {
        const double* const by = delta.data() + block.column;
        if (block.size == 8 && block.tangent == 7) {
          PoseManifold().Plus(block.data, by, expected.data());
        } else if (block.size == 8) {
          PoseTrayHeldManifold().Plus(block.data, by, expected.data());
        } else if (block.size == 7) {
          RigidManifold().Plus(block.data, by, expected.data());
        } else {
          for (int k = 0; k < block.size; ++k) expected[k] += by[k];
        }
      }
      for (int k = 0; k < block.size; ++k) CHECK(moved[k] == expected[k]);
    }
  }
}

TEST_CASE("the views of a landmark sum what its observations say") {
  SmallProblem problem;
  Model model(problem.tables, Options{});
  model.refresh(false);
  ImageTerms images(model);
  images.linearise();
  const int width = images.intrinsics().width();
  WithIntrinsics cross = WithIntrinsics::Zero(3, width);
  ImageTerms::OfIntrinsics alone(width);
  for (int32_t v = 0; v < images.first_view(model.landmarks()); ++v) images.linearise_with_intrinsics(v, cross, alone);
  std::vector<Mat3> information(SmallProblem::kLandmarks, Mat3::Zero());
  std::vector<Vec3> gradient(SmallProblem::kLandmarks, Vec3::Zero());
  LinearFactor factor;
  for (Kind kind : {Kind::Stereo, Kind::Mono}) {
    const auto [first, end] = model.factors_of(kind);
    for (int64_t f = first; f < end; ++f) {
      factor.at(model, f);
      const int64_t l = factor.blocks[0] - model.poses();
      const double w = factor.weight * factor.weight;
      information[l] += w * factor.by[0].transpose() * factor.by[0];
      gradient[l] += w * factor.by[0].transpose() * factor.residual;
    }
  }
  int32_t last_first_pose = 0;
  for (int64_t r = 0; r < model.landmarks(); ++r) {
    const int32_t l = images.landmark(r);
    CHECK(images.rank(l) == r);
    CHECK((images.at(r) == model.landmark(l)));
    Mat3 sum = Mat3::Zero();
    Vec3 g = Vec3::Zero();
    int32_t last = -1;
    for (const View& view : images.views_of_landmark(r)) {
      CHECK((view.landmark == r && view.pose > last));
      last = view.pose;
      sum += view.matrix(), g += view.gradient;
    }
    CHECK((sum - information[l]).norm() < 1e-10 * information[l].norm());
    CHECK((g - gradient[l]).norm() < 1e-9 * (1 + gradient[l].norm()));
    const int32_t first_pose = images.views_of_landmark(r).empty() ? last_first_pose : images.views_of_landmark(r)[0].pose;
    CHECK(first_pose >= last_first_pose);
    last_first_pose = first_pose;
  }
  size_t views = 0;
  for (int64_t i = 0; i < model.poses(); ++i) {
    for (int32_t v : images.views_of_pose(i)) {
      CHECK(images.view(v).pose == i);
      ++views;
    }
  }
  size_t by_landmark = 0;
  for (int64_t r = 0; r < model.landmarks(); ++r) by_landmark += images.views_of_landmark(r).size();
  CHECK(views == by_landmark);
}

TEST_CASE("surface terms are the surface factors, linear") {
  SmallProblem problem;
  Model model(problem.tables, Options{});
  model.refresh(false);
  ImageTerms images(model);
  const ReducedLayout layout(model);
  SurfaceTerms surface(model, images, layout);
  surface.linearise();
  const auto [first, end] = model.factors_of(Kind::Surface);
  std::vector<LinearFactor> by_row(end - first);
  double cost = 0;
  for (int64_t f = first; f < end; ++f) by_row[model.row_of(f)].at(model, f), cost += by_row[model.row_of(f)].cost;
  CHECK(surface.cost() == doctest::Approx(cost).epsilon(1e-12));
  size_t seen = 0;
  for (int64_t r = 0; r < model.landmarks(); ++r) {
    for (const SurfaceTerm& term : surface.of_landmark(r)) {
      const LinearFactor& factor = by_row[term.row];
      ++seen;
      CHECK(term.rank == r);
      CHECK(term.r == doctest::Approx(factor.weight * factor.residual[0]));
      CHECK((term.n.transpose() - factor.weight * factor.by[0]).norm() < 1e-10);
      CHECK((term.by_hull().transpose() - factor.weight * factor.by[1]).norm() < 1e-9);
      const auto nodes = surface.nodes(term);
      for (size_t k = 0; k < nodes.size(); ++k) {
        CHECK(surface.by_node(term, nodes[k]) == doctest::Approx(factor.weight * factor.by[2 + k](0, 0)));
      }
    }
  }
  CHECK(seen == by_row.size());
  for (int n = 0; n < layout.nodes(); ++n) {
    for (int32_t k : surface.of_node(n)) {
      const auto nodes = surface.nodes(surface[k]);
      CHECK(std::find(nodes.begin(), nodes.end(), n) != nodes.end());
    }
  }
}

TEST_CASE("small factors are those without a landmark, linear, weighted and whole") {
  for (const auto& held : held_sets()) {
    SmallProblem problem(held);
    Model model(problem.tables, Options{});
    model.refresh(false);
    const ReducedLayout layout(model);
    SmallFactors small(model, layout);
    small.linearise();
    const BlockMatrix& information = small.information();
    LinearFactor factor;
    Eigen::MatrixXd by(0, layout.size()), dense = Eigen::MatrixXd::Zero(layout.size(), layout.size());
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(layout.size());
    int64_t k = 0;
    for (Kind kind : {Kind::Prior, Kind::Attitude, Kind::Tray, Kind::Odometry, Kind::Range, Kind::Deviation}) {
      const auto [first, end] = model.factors_of(kind);
      for (int64_t f = first; f < end; ++f, ++k) {
        factor.at(model, f);
        by.setZero(factor.residual.size(), layout.size());
        size_t part = 0;
        for (size_t b = 0; b < factor.blocks.size(); ++b) {
          if (model.blocks()[factor.blocks[b]].tangent == 0) continue;
          const auto& at = small.parts(k)[part++];
          CHECK(at.block == layout.block_of(factor.blocks[b]));
          by.middleCols(information.offset(at.block) + std::max(at.border, 0), at.width) = factor.weight * factor.by[b];
        }
        CHECK(part == small.parts(k).size());
        dense += by.transpose() * by, gradient += by.transpose() * (factor.weight * factor.residual);
      }
    }
    CHECK(k == small.count());
    CHECK(information.size() == layout.size());
    Eigen::MatrixXd got = Eigen::MatrixXd::Zero(layout.size(), layout.size());
    for (int b = 0; b <= layout.blocks(); ++b) {
      const int at = information.offset(b), width = information.width(b);
      information.visit_column(b, [&](int row, const auto& m) { got.block(information.offset(row), at, m.rows(), width) = m; });
      CHECK((small.gradient(b) - gradient.segment(at, width)).norm() <= 1e-10 * gradient.norm());
      CHECK((small.diagonal(b) - dense.diagonal().segment(at, width)).norm() <= 1e-10 * dense.norm());
    }
    const Eigen::MatrixXd error = got - dense;
    CHECK(error.triangularView<Eigen::Lower>().toDenseMatrix().norm() < 1e-10 * dense.norm());
    std::array<double, kKindNames.size()> by_kind{};
    CHECK(small.cost(by_kind));
    const auto all = model.costs();
    for (Kind kind : {Kind::Prior, Kind::Odometry, Kind::Range}) {
      CHECK(by_kind[static_cast<size_t>(kind)] == doctest::Approx(all[static_cast<size_t>(kind)]).epsilon(1e-12));
    }
  }
}

TEST_CASE("the layout gives every free unknown a place of its own and held ones none") {
  for (const auto& held : held_sets()) {
    SmallProblem problem(held);
    Model model(problem.tables, Options{});
    const ReducedLayout layout(model);
    int width = 0;
    for (int b = 0; b < layout.blocks(); ++b) {
      CHECK(layout.block_of(layout.model_block(b)) == b);
      CHECK(layout.width(b) == model.blocks()[layout.model_block(b)].tangent);
      width += layout.width(b);
    }
    int border = 0;
    for (int g = 0; g < 7; ++g) {
      const int tangent = model.blocks()[layout.model_global(g)].tangent;
      CHECK(layout.column(g) == (tangent > 0 ? border : -1));
      CHECK(layout.block_of(layout.model_global(g)) == (tangent > 0 ? layout.blocks() : -1));
      border += tangent;
    }
    CHECK((layout.border() == border && layout.size() == width + border));
    CHECK(layout.block_of(static_cast<int>(model.poses())) == -1);
    CHECK(layout.size() + 3 * model.landmarks() == model.columns());
  }
}

TEST_CASE("two blocks of X meet where a landmark joins them, and nowhere else") {
  SmallProblem problem;
  Model model(problem.tables, Options{});
  model.refresh(false);
  const ReducedLayout layout(model);
  const ImageTerms images(model);
  const SurfaceTerms surface(model, images, layout);
  const SmallFactors small(model, layout);
  const TwistPattern pattern(layout, images, surface, small, 2);
  Eigen::MatrixXi expected = Eigen::MatrixXi::Zero(layout.poses(), layout.blocks());
  for (int64_t r = 0; r < model.landmarks(); ++r) {
    for (const View& a : images.views_of_landmark(r)) {
      for (const View& b : images.views_of_landmark(r)) expected(a.pose, b.pose) = 1;
      for (const SurfaceTerm& term : surface.of_landmark(r)) {
        for (int32_t node : surface.nodes(term)) expected(a.pose, layout.node(node)) = 1;
      }
    }
  }
  Eigen::MatrixXi got = Eigen::MatrixXi::Zero(layout.poses(), layout.blocks());
  int64_t next = 0;
  for (int i = 0; i < layout.poses(); ++i) {
    CHECK(images.sees(i) == !pattern.row(i).empty());
    if (images.sees(i)) CHECK(pattern.row(i)[0].block == i);
    for (const auto& entry : pattern.row(i)) {
      CHECK(entry.place == next);
      next += entry.block < layout.poses() ? 36 : 6;
      got(i, entry.block) = 1;
      if (entry.block < layout.poses()) got(entry.block, i) = 1;
    }
  }
  CHECK(next == pattern.size());
  CHECK(got == expected);
  size_t below = 0;
  for (int b = 0; b < layout.blocks(); ++b) {
    for (const auto& entry : pattern.below(b)) {
      CHECK((entry.block < b && expected(entry.block, b) == 1));
      ++below;
    }
  }
  size_t above = 0;
  for (int i = 0; i < layout.poses(); ++i) above += pattern.row(i).empty() ? 0 : pattern.row(i).size() - 1;
  CHECK(below == above);
}

TEST_CASE("the information for covariances is the dense Schur complement") {
  for (const auto& held : held_sets()) {
    SmallProblem problem(held);
    Model model(problem.tables, Options{});
    model.refresh(false, true);
    const Information information(model);
    const Dense dense(model);
    const int64_t first = model.blocks()[model.poses()].column, landmarks = 3 * model.landmarks();
    const Eigen::MatrixXd W = dense.information.middleRows(first, landmarks);
    const Eigen::MatrixXd V = dense.information.block(first, first, landmarks, landmarks);
    const Eigen::MatrixXd S = dense.information - W.transpose() * V.ldlt().solve(W);
    const double size = S.cwiseAbs().maxCoeff();
    for (int a = 0; a < static_cast<int>(model.blocks().size()); ++a) {
      const int pa = information.position(a);
      const bool landmark = a >= model.poses() && a < model.poses() + model.landmarks();
      CHECK((pa < 0) == (landmark || model.blocks()[a].tangent == 0));
      if (pa < 0) continue;
      CHECK(information.block_at(pa) == a);
      const Eigen::MatrixXd own = information.reduced().get(pa, pa).selfadjointView<Eigen::Lower>();
      const Block& block = model.blocks()[a];
      CHECK((own - S.block(block.column, block.column, block.tangent, block.tangent)).norm() < 1e-9 * size);
      const int hull = information.position(model.block("T_g_M"));
      if (hull < 0 || hull == pa) continue;
      const Block& other = model.blocks()[model.block("T_g_M")];
      CHECK((information.reduced().get(pa, hull) - S.block(block.column, other.column, block.tangent, 6)).norm() < 1e-9 * size);
    }
  }
}
