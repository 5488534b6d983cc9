// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "sparse/fronts.h"

#include <Eigen/Dense>
#include <optional>
#include <random>

#include "expect.h"
#include "sparse/reduced_system.h"

using namespace hullrecon;

namespace {

// Blocks of several widths, in a chain with links at random and a border that all meet.
struct Graph {
  std::vector<int> width;
  int border;
  std::vector<std::vector<int>> meets;  // of each block, the others, both ways

  Graph(int blocks, int border_width, int links, unsigned seed) : border(border_width), meets(blocks) {
    std::mt19937 rng(seed);
    for (int b = 0; b < blocks; ++b) width.push_back(1 + static_cast<int>(rng() % 7));
    for (int b = 0; b + 1 < blocks; ++b) link(b, b + 1);
    for (int k = 0; k < links; ++k) link(static_cast<int>(rng() % blocks), static_cast<int>(rng() % blocks));
  }
  void link(int a, int b) {
    if (a == b || std::count(meets[a].begin(), meets[a].end(), b)) return;
    meets[a].push_back(b), meets[b].push_back(a);
  }
  ReducedSystem reduced(int threads, const std::optional<std::vector<int>>& interface = {},
                        std::pmr::memory_resource* pages = std::pmr::get_default_resource()) const {
    std::vector<int64_t> start{0};
    std::vector<int32_t> all;
    for (const auto& others : meets) {
      all.insert(all.end(), others.begin(), others.end());
      start.push_back(static_cast<int64_t>(all.size()));
    }
    return ReducedSystem(width, border, start, all, threads, interface, pages);
  }
};

// Fills the system with numbers on the graph, `ridge` on its diagonal; the same matrix, dense, in the order of the system.
Eigen::MatrixXd fill(const Graph& graph, ReducedSystem& reduced, double ridge) {
  std::mt19937 rng(7);
  std::normal_distribution<double> normal;
  const auto random = [&](int rows, int columns) {
    return Eigen::MatrixXd(Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(rng); }));
  };
  const auto blocks = static_cast<int>(graph.width.size());
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(reduced.size(), reduced.size());
  const auto put = [&](int a, int b, const Eigen::MatrixXd& m) {
    dense.block(reduced.offset(a), reduced.offset(b), m.rows(), m.cols()) += m;
    if (a != b) dense.block(reduced.offset(b), reduced.offset(a), m.cols(), m.rows()) += m.transpose();
  };
  reduced.clear();
  for (int a = 0; a < blocks; ++a) {
    for (int b : graph.meets[a]) {
      if (b > a) continue;
      const Eigen::MatrixXd m = random(graph.width[a], graph.width[b]);
      reduced.add(a, b, m), put(a, b, m);
    }
    const Eigen::MatrixXd m = random(graph.border, graph.width[a]);
    reduced.add_border(a, m), put(blocks, a, m);
    const Eigen::MatrixXd own = random(graph.width[a], graph.width[a]);
    reduced.add_own(a, Eigen::MatrixXd(own + own.transpose())), put(a, a, own + own.transpose());
  }
  reduced.add_diagonal(Eigen::VectorXd::Constant(reduced.size(), ridge));
  dense.diagonal().array() += ridge;
  return dense;
}

void expect_solved(const Graph& graph, int threads) {
  ReducedSystem reduced = graph.reduced(threads);
  const Eigen::MatrixXd dense = fill(graph, reduced, 4.0 * reduced.size());
  Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(reduced.size(), -1, 1);
  const Eigen::VectorXd b = x;
  REQUIRE(reduced.factor());
  reduced.solve(x);
  CHECK((dense * x - b).norm() < 1e-12 * b.norm());
}

}  // namespace

TEST_CASE("the system by fronts is the dense one") {
  for (int blocks : {1, 2, 9, 60, 300}) {
    for (int border : {0, 1, 12}) {
      for (int links : {0, blocks / 2, 3 * blocks}) expect_solved(Graph(blocks, border, links, blocks + links), 2);
    }
  }
}

TEST_CASE("fronts of several tiles") {
  expect_solved(Graph(140, 12, 140 * 140, 3), 2);  // all meet all: one front of 560 columns
  expect_solved(Graph(40, 300, 60, 3), 2);         // a border longer than two tiles
}

TEST_CASE("a system of nothing but its border, and of nothing at all") {
  expect_solved(Graph(0, 5, 0, 1), 2);
  ReducedSystem nothing = Graph(0, 0, 0, 1).reduced(2);
  CHECK(nothing.factor());
  CHECK(nothing.size() == 0);
}

TEST_CASE("the same bytes for any number of threads") {
  const Graph graph(400, 12, 900, 5);
  Eigen::VectorXd first;
  for (int threads : {1, 2, 3}) {
    ReducedSystem reduced = graph.reduced(threads);
    fill(graph, reduced, 4.0 * reduced.size());
    REQUIRE(reduced.factor());
    Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(reduced.size(), -1, 1);
    reduced.solve(x);
    if (threads == 1) first = x;
    CHECK(x == first);
  }
}

TEST_CASE("a matrix in a file has the bytes of one in memory") {
  for (int links : {140 * 140, 200}) {  // a panel that is larger than what stays in memory, and many small ones
    const Graph graph(140, 12, links, 3);
    PageFile file("/tmp");
    ReducedSystem filed = graph.reduced(2, {}, &file), kept = graph.reduced(2);
    Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(kept.size(), -1, 1), y = x;
    for (ReducedSystem* reduced : {&filed, &kept}) {
      fill(graph, *reduced, 4.0 * reduced->size());
      REQUIRE(reduced->factor());
      reduced->solve(reduced == &filed ? x : y);
      reduced->invert();
    }
    CHECK(x == y);
    for (int a = 0; a < 140; ++a) CHECK(filed.block(a, 140) == kept.block(a, 140));
  }
}

TEST_CASE("an indefinite system is refused, and the next one is solved") {
  const Graph graph(300, 12, 300, 2);
  ReducedSystem reduced = graph.reduced(2);
  fill(graph, reduced, 1.0);
  CHECK_FALSE(reduced.factor());
  const Eigen::MatrixXd dense = fill(graph, reduced, 4.0 * reduced.size());
  REQUIRE(reduced.factor());
  Eigen::VectorXd x = Eigen::VectorXd::Ones(reduced.size());
  reduced.solve(x);
  CHECK((dense * x - Eigen::VectorXd::Ones(reduced.size())).norm() < 1e-10);
}

TEST_CASE("rows and columns of each front lie on the elimination tree") {
  const Graph graph(300, 12, 300, 2);
  const ReducedSystem reduced = graph.reduced(1);
  const FrontTree& tree = reduced.tree();
  int columns = 0;
  for (int f = 0; f < static_cast<int>(tree.fronts().size()); ++f) {
    columns += tree.fronts()[f].size;
    int carried = 0;
    for (const Run& run : tree.runs(f)) {
      CHECK(run.from == carried);
      carried += run.length;
    }
    CHECK(carried == tree.fronts()[f].below());
    for (int child : tree.children(f)) CHECK(tree.fronts()[child].parent == f);
  }
  CHECK(columns == reduced.size());
}

TEST_CASE("a part leaves the Schur complement on its interface and border") {
  for (const std::vector<int>& interface : {std::vector<int>{}, {7}, {55, 3, 20}, {0, 1, 2, 3, 4, 5, 6, 7, 8}}) {
    for (int border : {0, 12}) {
      const Graph graph(60, border, 90, 4);
      ReducedSystem part = graph.reduced(2, interface);
      const Eigen::MatrixXd dense = fill(graph, part, 4.0 * part.size());
      const int inner = part.interior(), outer = part.size() - inner;
      for (size_t k = 0; k < interface.size(); ++k) CHECK(part.offset(interface[k]) >= inner);
      Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(part.size(), -1, 1);
      const Eigen::VectorXd b = x;
      REQUIRE(part.factor());
      const Eigen::MatrixXd gain = dense.bottomLeftCorner(outer, inner) * dense.topLeftCorner(inner, inner).inverse();
      const Eigen::MatrixXd expected = dense.bottomRightCorner(outer, outer) - gain * dense.topRightCorner(inner, outer);
      const Eigen::MatrixXd left = part.condensed().selfadjointView<Eigen::Lower>();
      CHECK((left - expected).norm() <= 1e-12 * dense.norm());
      part.forward(x);
      CHECK((x.tail(outer) - (b.tail(outer) - gain * b.head(inner))).norm() <= 1e-12 * b.norm());
      x.tail(outer) = expected.ldlt().solve(Eigen::VectorXd(x.tail(outer)));
      part.backward(x);
      CHECK((dense * x - b).norm() < 1e-12 * b.norm());
    }
  }
}

TEST_CASE("an interface of which no block stands alone keeps the others' order") {
  const Graph graph(40, 5, 60, 8);
  const ReducedSystem part = graph.reduced(1, std::vector<int>{12, 30, 2});
  CHECK(part.offset(12) < part.offset(30));
  CHECK(part.offset(30) < part.offset(2));
  CHECK(part.offset(2) < part.offset(40));  // the border
  CHECK(part.tree().fronts().back().size == graph.width[12] + graph.width[30] + graph.width[2] + 5);
}

TEST_CASE("the inverse on the factor's pattern is the dense one, of a whole and of a part") {
  for (const std::optional<std::vector<int>>& interface :
       {std::optional<std::vector<int>>{}, {std::vector<int>{}}, {std::vector<int>{31, 8, 50}}}) {
    const Graph graph(60, 7, 90, 4);
    ReducedSystem reduced = graph.reduced(2, interface);
    const Eigen::MatrixXd expected = fill(graph, reduced, 4.0 * reduced.size()).inverse();
    REQUIRE(reduced.factor());
    const int outer = reduced.size() - reduced.interior();
    if (interface) reduced.condensed() = expected.bottomRightCorner(outer, outer);
    reduced.invert();
    const auto compare = [&](int a, int b, int columns) {
      const Eigen::MatrixXd got = reduced.block(a, b);
      CHECK((got - expected.block(reduced.offset(a), reduced.offset(b), graph.width[a], columns)).norm() <
            1e-12 * expected.norm());
    };
    for (int a = 0; a < 60; ++a) {
      compare(a, a, graph.width[a]);
      compare(a, 60, 7);
      for (int b : graph.meets[a]) compare(a, b, graph.width[b]);
    }
  }
}
