// A pair of fields as one vector of unknowns, log κ first, for tests that hold products to dense
// matrices.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>

#include "inverse/problem/objective.h"

namespace kappamu::inverse {

inline CoefficientPair parted(const Eigen::VectorXd& u) {
  const auto cells = static_cast<std::ptrdiff_t>(u.size() / 2);
  return {{u.begin(), u.begin() + cells}, {u.begin() + cells, u.end()}};
}

inline Eigen::VectorXd joined(const CoefficientPair& fields) {
  Eigen::VectorXd u(static_cast<Eigen::Index>(2 * fields.log_mu.size()));
  std::copy(fields.log_mu.begin(), fields.log_mu.end(),
            std::copy(fields.log_kappa.begin(), fields.log_kappa.end(), u.begin()));
  return u;
}

}  // namespace kappamu::inverse
