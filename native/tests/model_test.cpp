// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Tables to unknowns and factors.
#include "model/model.h"

#include "common/errors.h"
#include "small_problem.h"

#include "expect.h"

using namespace hullrecon;

TEST_CASE("blocks stand in their order, their columns side by side, held ones without") {
  for (const auto& held : held_sets()) {
    SmallProblem problem(held);
    Model model(problem.tables, Options{});
    int64_t column = 0;
    for (const Block& block : model.blocks()) {
      CHECK(block.column == (block.tangent > 0 ? column : -1));
      column += block.tangent;
    }
    CHECK(model.columns() == column);
    CHECK(model.name_of(3) == "pose 3");
    CHECK(model.name_of(static_cast<int>(model.poses()) + 2) == "landmark 2");
    CHECK(model.name_of(model.block("T_s_ct")) == "T_s_ct");
    CHECK(model.name_of(model.first_node() + 1) == "deviation 1");
    CHECK(model.block("elsewhere") == -1);
    CHECK(static_cast<int>(model.blocks().size()) == model.first_node() + SmallProblem::kNodes);
  }
}

TEST_CASE("the unknowns are copies of the tables") {
  SmallProblem problem;
  Model model(problem.tables, Options{});
  for (int64_t l = 0; l < model.landmarks(); ++l) CHECK((model.landmark(l) == Vec3(problem.tables.landmark.row(l))));
  CHECK(std::equal(problem.tables.intrinsics_bottom.data, problem.tables.intrinsics_bottom.data + 9,
                   model.blocks()[model.block("intrinsics_bottom")].data));
  model.unknowns()[0] += 1;
  CHECK(model.blocks()[0].data[0] == problem.tables.pose.data[0] + 1);
}

TEST_CASE("factors are numbered by kind, then by row, and name the blocks of their row") {
  SmallProblem problem;
  Model model(problem.tables, Options{});
  const Tables& t = problem.tables;
  int64_t next = 0;
  for (size_t k = 0; k < kKindNames.size(); ++k) {
    const auto [first, end] = model.factors_of(static_cast<Kind>(k));
    CHECK(first == next);
    next = end;
    for (int64_t f = first; f < end; ++f) CHECK(model.kind_of(f) == static_cast<Kind>(k));
  }
  CHECK(next == model.factors());
  std::vector<int32_t> blocks;
  const auto globals = static_cast<int32_t>(model.poses() + model.landmarks());
  for (int64_t k = 0; k < t.stereo_node.rows(); ++k) {
    const int64_t f = model.factors_of(Kind::Stereo).first + k;
    model.blocks_of(f, blocks);
    CHECK(model.row_of(f) == k);
    CHECK((blocks[0] == model.poses() + t.stereo_landmark.data[k] && blocks[1] == t.stereo_node.data[k]));
    CHECK((blocks[2] == globals + kCamera && blocks[3] == globals + kBottom && blocks.size() == 6));
  }
  for (int64_t k = 0; k < t.mono_node.rows(); ++k) {
    model.blocks_of(model.factors_of(Kind::Mono).first + k, blocks);
    const bool bottom = t.mono_camera.data[k] == 1;
    CHECK(blocks.size() == (bottom ? 5U : 4U));
    CHECK(blocks[3] == globals + (bottom ? kBottomIntrinsics : kTopIntrinsics));
  }
  for (int64_t k = 0; k < t.odometry_first.rows(); ++k) {
    model.blocks_of(model.factors_of(Kind::Odometry).first + k, blocks);
    CHECK((blocks ==
           std::vector<int32_t>{t.odometry_first.data[k], t.odometry_second.data[k], globals + kNavigation, globals + kDvl}));
  }
}

TEST_CASE("without surface factors there are none, and rows of no weight make none") {
  SmallProblem problem;
  Options naive;
  naive.method = "naive";
  const auto count = [](const Model& m) { return m.factors_of(Kind::Surface).second - m.factors_of(Kind::Surface).first; };
  CHECK(count(Model(problem.tables, naive)) == 0);
  std::vector<double> weight(problem.tables.surface_weight.data, problem.tables.surface_weight.data + 16);
  weight[3] = weight[7] = 0;
  problem.tables.surface_weight.data = weight.data();
  const Model model(problem.tables, Options{});
  CHECK(count(model) == 14);
  CHECK(model.row_of(model.factors_of(Kind::Surface).first + 3) == 4);
}

TEST_CASE("priors of held blocks are left out") {
  for (const auto& held : held_sets()) {
    SmallProblem problem(held);
    const Model model(problem.tables, Options{});
    int64_t expected = 1 + 7;
    for (const auto& name : held) expected -= name != "tray" && name != "deviation";
    CHECK(model.factors_of(Kind::Prior).second == expected);
  }
}

TEST_CASE("a factor has the same residual and cost with and without derivatives") {
  SmallProblem problem;
  Model model(problem.tables, Options{});
  model.refresh(false);
  LinearFactor linear;
  std::array<double, kKindNames.size()> costs{};
  for (int64_t f = 0; f < model.factors(); ++f) {
    linear.at(model, f);
    std::vector<const double*> x;
    for (int32_t b : linear.blocks) x.push_back(model.blocks()[b].data);
    Eigen::VectorXd r(model.rows_of(f));
    REQUIRE(model.evaluate(f, {}, x.data(), r.data(), nullptr));
    CHECK((linear.residual - r).norm() == 0.0);
    costs[static_cast<size_t>(model.kind_of(f))] += linear.cost;
  }
  for (size_t k = 0; k < costs.size(); ++k) CHECK(model.costs()[k] == doctest::Approx(costs[k]).epsilon(1e-12));
}

TEST_CASE("labels are the mixture's, the method's or those held") {
  SmallProblem problem;
  const auto labels = [&](const char* method, bool in_solve) {
    Options options;
    options.method = method, options.labels_in_solve = in_solve;
    Model model(problem.tables, options);
    model.refresh(false, true);
    const auto before = model.labels();
    for (int64_t l = 0; l < model.landmarks(); ++l) model.blocks()[model.poses() + l].data[2] += 0.5;
    model.refresh(false, true);
    return std::pair(before, model.labels());
  };
  const auto [free, free_moved] = labels("maxmix", true);
  CHECK((free[0] == 0 && free[1] == 1 && free[4] == 0));  // every fourth landmark stands 0.3 m off
  CHECK(std::count(free_moved.begin(), free_moved.end(), 1) == 0);
  const auto [held, held_moved] = labels("maxmix", false);
  CHECK((held == free && held_moved == free));
  const auto [none, none_moved] = labels("naive", true);
  CHECK(std::count(none_moved.begin(), none_moved.end(), 0) == 16);
  const auto [all, all_moved] = labels("geva", true);
  CHECK(std::count(all_moved.begin(), all_moved.end(), 1) == 16);
}

TEST_CASE("nodes named twice are one, and those of no weight are none") {
  NodeTable table;
  const int32_t index[] = {4, 1, 4, 2, 3, 3};
  const double weight[] = {0.5, 0.25, 0.25, 0.0, 0.5, -0.5};
  table.add(index, weight, 6);
  table.add(index, weight, 0);
  table.add(index + 3, weight + 4, 1);
  CHECK((table.nodes(0).size() == 2 && table.nodes(0)[0] == 1 && table.nodes(0)[1] == 4));
  CHECK((table.at(0).weight[0] == 0.25 && table.at(0).weight[1] == 0.75));
  CHECK((table.nodes(1).empty() && table.at(1).weight.empty()));
  CHECK((table.nodes(2)[0] == 2 && table.at(2).weight[0] == 0.5));
  CHECK(table.nodes(7).empty());
}

TEST_CASE("a linear factor that cannot be evaluated names itself") {
  SmallProblem problem;
  Model model(problem.tables, Options{});
  double* const pose = model.blocks()[2].data;
  pose[3] = 0, pose[4] = std::sqrt(0.5), pose[5] = 0, pose[6] = std::sqrt(0.5);
  LinearFactor factor;
  try {
    factor.at(model, model.factors_of(Kind::Attitude).first + 2);
    CHECK(false);
  } catch (const StageError& error) {
    CHECK(error.where == "attitude 2");
  }
}

TEST_CASE("a table counts its rows and their width") {
  const double values[24] = {};
  const Table<double> cube{"cube", {2, 3, 4}, values}, row{"row", {5}, values}, none;
  CHECK((cube.rows() == 2 && cube.width() == 12 && cube.row(1) == values + 12));
  CHECK((row.rows() == 5 && row.width() == 1));
  CHECK(none.rows() == 0);
}
