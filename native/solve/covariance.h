// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "solve/joined_problem.h"

namespace hullrecon {

// Marginals in tangent coordinates, row major; zero where a coordinate is held.
struct Covariance {
  std::vector<double> pose;            // (n, 7, 7)
  std::vector<double> pose_hull;       // (n, 7, 6) with T_g_M
  std::vector<double> landmark;        // (L, 3, 3), empty unless asked for, as is the next
  std::vector<double> landmark_hull;   // (L, 3, 6) with T_g_M, empty where that is held
  std::vector<double> deviation;       // (F,) variances
  std::vector<double> deviation_hull;  // (F, 6) with T_g_M
  std::map<std::string, Eigen::MatrixXd> global;
  std::array<double, kKindNames.size()> leverage{};  // of the factors that meet no landmark, by kind: trace of J Z J'
};

// From the information at the model's unknowns: Huber rows weighted by rho', mixture rows by their label's sigma.
// Throws StageError naming what is not determined.
Covariance covariance(Model& model, bool of_landmarks = true);

// The same of the parts of a problem, of each what it holds: marginals of the whole problem.
std::vector<Covariance> covariance(const std::vector<ProblemPart>& parts, bool of_landmarks = true);

// Marginals of a model whose system without landmarks has been inverted.
Covariance marginals(const Model& model, const Schur& inverse, bool of_landmarks);

}  // namespace hullrecon
