// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Block matrices, the tree of fronts and the reduced system against dense twins.
#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <set>

#include "sparse/block_matrix.h"
#include "sparse/reduced_system.h"

#include "expect.h"

using namespace hullrecon;

namespace {

// A random graph of blocks, both ways; the border is not in it.
struct Graph {
  std::vector<int> width;
  std::vector<std::set<int32_t>> neighbours;

  Graph(int blocks, int links, unsigned seed) : neighbours(blocks) {
    std::mt19937 rng(seed);
    for (int b = 0; b < blocks; ++b) width.push_back(b % 3 == 2 ? 1 : 6 + static_cast<int>(rng() % 2));
    for (int k = 0; k < links; ++k) {
      const auto a = static_cast<int32_t>(rng() % static_cast<unsigned>(blocks));
      const auto b = static_cast<int32_t>((static_cast<unsigned>(a) + 1 + rng() % 4) % static_cast<unsigned>(blocks));
      if (a != b) neighbours[a].insert(b), neighbours[b].insert(a);
    }
  }
  std::vector<int64_t> start() const {
    std::vector<int64_t> out{0};
    for (const auto& n : neighbours) out.push_back(out.back() + static_cast<int64_t>(n.size()));
    return out;
  }
  std::vector<int32_t> list() const {
    std::vector<int32_t> out;
    for (const auto& n : neighbours) out.insert(out.end(), n.begin(), n.end());
    return out;
  }
};

// The same numbers, dense, in the order of ReducedSystem's scalars.
Eigen::MatrixXd fill(ReducedSystem& system, const Graph& graph, int border, unsigned seed) {
  std::srand(seed);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(system.size(), system.size());
  const auto blocks = static_cast<int>(graph.width.size());
  const auto put = [&](int a, int b, const Eigen::MatrixXd& m) {
    dense.block(system.offset(a), system.offset(b), m.rows(), m.cols()) += m;
    if (a != b) dense.block(system.offset(b), system.offset(a), m.cols(), m.rows()) += m.transpose();
  };
  for (int a = 0; a < blocks; ++a) {
    for (int32_t b : graph.neighbours[a]) {
      if (b < a) continue;
      const Eigen::MatrixXd m = Eigen::MatrixXd::Random(graph.width[a], graph.width[b]);
      a % 2 == 0 ? system.add(a, b, m) : system.add(b, a, m.transpose());
      put(a, b, m);
    }
    const Eigen::MatrixXd with_border = Eigen::MatrixXd::Random(border, graph.width[a]);
    system.add_border(a, with_border);
    put(blocks, a, with_border);
    const Eigen::MatrixXd own = Eigen::MatrixXd::Random(graph.width[a], graph.width[a]);
    const Eigen::MatrixXd symmetric = own + own.transpose();
    system.add_own(a, symmetric);
    put(a, a, symmetric);
  }
  system.add_own(blocks, Eigen::MatrixXd(Eigen::MatrixXd::Identity(border, border)));
  put(blocks, blocks, Eigen::MatrixXd::Identity(border, border));
  const Eigen::VectorXd diagonal = Eigen::VectorXd::LinSpaced(system.size(), 40, 80);
  system.add_diagonal(diagonal);
  dense.diagonal() += diagonal;
  return dense;
}

}  // namespace

TEST_CASE("the reduced system solves as the dense matrix does, with a border and without, for any threads") {
  for (int border : {0, 6, 30}) {
    for (int blocks : {1, 3, 17, 60}) {
      const Graph graph(blocks, 3 * blocks, static_cast<unsigned>(blocks));
      Eigen::VectorXd first;
      for (int threads : {1, 3}) {
        ReducedSystem system(graph.width, border, graph.start(), graph.list(), threads);
        for (int again = 0; again < 2; ++again) {  // a second time from cleared panels
          system.clear();
          const Eigen::MatrixXd dense = fill(system, graph, border, static_cast<unsigned>(blocks + border));
          const Eigen::VectorXd rhs = Eigen::VectorXd::LinSpaced(system.size(), -1, 2);
          Eigen::VectorXd x = rhs;
          REQUIRE(system.factor());
          system.solve(x);
          CHECK((dense * x - rhs).norm() < 1e-10 * rhs.norm());
          if (first.size() == 0) first = x;
          CHECK((x.array() == first.array()).all());
        }
      }
    }
  }
}

TEST_CASE("a system that is not positive definite is refused, and the next one is not") {
  const Graph graph(20, 60, 5);
  ReducedSystem system(graph.width, 6, graph.start(), graph.list(), 2);
  fill(system, graph, 6, 1);
  Eigen::VectorXd down = Eigen::VectorXd::Zero(system.size());
  down[system.size() / 2] = -1e4;
  system.add_diagonal(down);
  CHECK_FALSE(system.factor());
  system.clear();
  fill(system, graph, 6, 1);
  CHECK(system.factor());
}

TEST_CASE("fronts partition the columns, and each stands with its rows in its parent") {
  const Graph graph(50, 150, 9);
  const ReducedSystem system(graph.width, 6, graph.start(), graph.list(), 1);
  const FrontTree& tree = system.tree();
  int32_t next = 0;
  int columns = 0;
  for (int f = 0; f < static_cast<int>(tree.fronts().size()); ++f) {
    const Front& front = tree.fronts()[f];
    CHECK(front.first == next);
    next = front.last;
    columns += front.size;
    CHECK((front.parent > f || (front.parent == -1 && f + 1 == static_cast<int>(tree.fronts().size()))));
    int rows = 0, covered = 0, last = front.last - 1;
    for (const FrontRow& row : tree.rows(f)) {
      CHECK((row.block > last && row.place == front.size + rows));
      last = row.block;
      rows += tree.offset(row.block + 1) - tree.offset(row.block);
    }
    CHECK(rows == front.below());
    for (const Run& run : tree.runs(f)) {
      const Front& parent = tree.fronts()[front.parent];
      CHECK(run.from == covered);
      covered += run.length;
      CHECK((run.to + run.length <= parent.size || run.to >= parent.size));
      CHECK(run.to + run.length <= parent.height);
    }
    CHECK(covered == (front.parent >= 0 ? front.below() : 0));
    int descendants = 0;
    double work = 0;
    for (int child : tree.children(f)) {
      CHECK(tree.fronts()[child].parent == f);
      descendants += tree.fronts()[child].descendants + 1;
      work += tree.fronts()[child].work;
    }
    CHECK(descendants == front.descendants);
    CHECK(work <= front.work);
  }
  CHECK(columns == system.size());
  CHECK(tree.offset(next) == system.size());
}

namespace {

// Numbers that wait at most for a parent to take them, in the order of these fronts.
double most_waiting(const FrontTree& tree, const std::vector<int32_t>& order) {
  double now = 0, most = 0;
  const auto leaves = [&](int f) { return std::pow(tree.fronts()[f].below(), 2); };
  for (int f : order) {
    now += leaves(f), most = std::max(most, now);
    for (int child : tree.children(f)) now -= leaves(child);
  }
  return most;
}

// All orders in which subtrees are visited one after another, each front after its children.
std::vector<std::vector<int32_t>> postorders(const FrontTree& tree, int front) {
  std::vector<std::vector<int32_t>> out;
  std::vector<int32_t> children(tree.children(front).begin(), tree.children(front).end());
  std::sort(children.begin(), children.end());
  do {
    std::vector<std::vector<int32_t>> begun{{}};
    for (int child : children) {
      std::vector<std::vector<int32_t>> longer;
      for (const auto& first : begun) {
        for (const auto& next : postorders(tree, child)) {
          longer.push_back(first);
          longer.back().insert(longer.back().end(), next.begin(), next.end());
        }
      }
      begun = longer;
    }
    for (auto& order : begun) order.push_back(front), out.push_back(order);
  } while (std::next_permutation(children.begin(), children.end()));
  return out;
}

}  // namespace

TEST_CASE("fronts take their turns so that least waits: no postorder of the tree is better") {
  for (unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    const Graph graph(16, 14, seed);
    const ReducedSystem system(graph.width, 6, graph.start(), graph.list(), 1);
    const FrontTree& tree = system.tree();
    const std::vector<int32_t> order(tree.order().begin(), tree.order().end());
    const auto all = postorders(tree, static_cast<int>(tree.fronts().size()) - 1);
    CHECK(std::find(all.begin(), all.end(), order) != all.end());
    for (const auto& other : all) CHECK(most_waiting(tree, order) <= most_waiting(tree, other));
    for (size_t k = 0; k < order.size(); ++k) CHECK(tree.fronts()[order[k]].turn == static_cast<int32_t>(k));
  }
}

TEST_CASE("the pattern of the fronts holds every entry of the dense factor") {
  const Graph graph(30, 70, 3);
  ReducedSystem system(graph.width, 6, graph.start(), graph.list(), 1);
  const Eigen::MatrixXd dense = fill(system, graph, 6, 2);
  const Eigen::MatrixXd L = dense.llt().matrixL();
  const FrontTree& tree = system.tree();
  std::vector<int> block_of;
  int blocks = 0;
  for (; tree.offset(blocks) < system.size(); ++blocks) {
    for (int k = tree.offset(blocks); k < tree.offset(blocks + 1); ++k) block_of.push_back(blocks);
  }
  for (const Front& front : tree.fronts()) {
    std::set<int> rows;
    const auto f = static_cast<int>(&front - tree.fronts().data());
    for (const FrontRow& row : tree.rows(f)) rows.insert(row.block);
    for (int c = tree.offset(front.first); c < tree.offset(front.last); ++c) {
      for (int r = tree.offset(front.last); r < system.size(); ++r) {
        if (std::abs(L(r, c)) > 1e-12) CHECK(rows.count(block_of[r]) == 1);
      }
    }
  }
}

TEST_CASE("a block matrix holds its lower half on its pattern, adds to either and reads both") {
  const auto pair = [](uint64_t column, uint64_t row) { return (column << 32) | row; };
  BlockMatrix m({2, 3, 1}, {pair(0, 0), pair(0, 2), pair(1, 1), pair(1, 2), pair(2, 2)});
  CHECK((m.size() == 6 && m.blocks() == 3 && m.offset(2) == 5 && m.width(1) == 3));
  Eigen::MatrixXd row(1, 2), column(3, 1);
  row << 1, 2;
  column << 3, 4, 5;
  m.add(2, 0, row);
  m.add(1, 2, column);  // above the diagonal
  m.add(0, 2, row.transpose());
  CHECK((m.get(2, 0) == 2 * row));
  CHECK((m.get(0, 2) == 2 * row.transpose()));
  CHECK((m.get(2, 1) == column.transpose()));
  std::vector<std::pair<int, int>> seen;
  double sum = 0;
  m.each_scalar([&](int r, int c, double& v) { seen.emplace_back(c, r), sum += v; });
  CHECK(std::is_sorted(seen.begin(), seen.end()));
  CHECK(seen.size() == 3 + 2 + 6 + 3 + 1);
  CHECK(sum == 2 * 3 + 12);
}
