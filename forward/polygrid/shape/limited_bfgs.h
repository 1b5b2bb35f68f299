// Limited-memory BFGS with Armijo backtracking (Nocedal and Wright 2006, algorithm 7.4), for
// functions that are infinite where they are not allowed. Its two loops run over coefficients of
// the last steps, their changes of the gradient, and the gradient, by the products of these (Chen,
// Wang and Zhou 2014): each iteration reads them twice, on all cores.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/parallel.h"

namespace kappamu::forward {

/// `function(x, gradient)` returns the value and sets the gradient; it is finite at `x`.
/// `first_step`: the largest change of an unknown in the first iteration. Returns the last value.
template <class Function>
double minimise(const Function& function, Eigen::VectorXd& x, int iterations, double first_step) {
  using Eigen::Index;
  constexpr Index memory = 6, at_gradient = 2 * memory;  // columns: steps, changes, gradient
  constexpr std::size_t piece_rows = 4096;               // of which all columns stay in the cache
  constexpr double decrease = 1e-4;
  using Products = Eigen::Matrix<double, at_gradient + 1, at_gradient + 1>;
  using NewProducts = Eigen::Matrix<double, at_gradient + 1, 3>;
  using Coefficients = Eigen::Matrix<double, at_gradient + 1, 1>;
  const auto size = static_cast<std::size_t>(x.size());
  const auto for_all_pieces = [&](const auto& work) {
    for_pieces(size, piece_rows, [&](std::size_t piece, std::size_t begin, std::size_t end) {
      work(piece, static_cast<Index>(begin), static_cast<Index>(end - begin));
    });
  };
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(x.size(), at_gradient + 1);
  Products products = Products::Zero();
  std::vector<NewProducts> of_piece(pieces(size, piece_rows));
  std::vector<Index> pairs;  // their places among the steps, oldest first
  Eigen::VectorXd gradient(x.size()), next(x.size()), direction(x.size());
  double value = function(x, gradient);
  columns.col(at_gradient) = gradient;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    Coefficients by = Coefficients::Zero();
    by[at_gradient] = -1.0;
    if (pairs.empty()) {
      const double largest = columns.col(at_gradient).template lpNorm<Eigen::Infinity>();
      if (!(largest > 0.0)) return value;
      by *= first_step / largest;
      products(at_gradient, at_gradient) = columns.col(at_gradient).squaredNorm();
    } else {
      std::array<double, memory> alpha{};
      for (auto k = pairs.rbegin(); k != pairs.rend(); ++k) {
        double& mine = alpha[static_cast<std::size_t>(*k)];
        mine = products.row(*k).dot(by) / products(*k, *k + memory);
        by[*k + memory] -= mine;
      }
      const Index last = pairs.back(), change = last + memory;
      by *= products(last, change) / products(change, change);
      for (const Index k : pairs) {
        const double beta = products.row(k + memory).dot(by) / products(k, k + memory);
        by[k] += alpha[static_cast<std::size_t>(k)] - beta;
      }
    }
    const double slope = products.row(at_gradient).dot(by);
    if (!(slope < 0.0)) return value;
    for_all_pieces([&](std::size_t, Index begin, Index rows) {
      direction.segment(begin, rows).noalias() = columns.middleRows(begin, rows) * by;
    });
    double length = 1.0, next_value = 0.0;
    for (int halvings = 0;; ++halvings) {
      next = x + length * direction;
      next_value = function(next, gradient);
      if (next_value <= value + decrease * length * slope) break;
      if (halvings == 30) return value;
      length /= 2.0;
    }
    const bool full = pairs.size() == memory;
    const Index place = full ? pairs.front() : static_cast<Index>(pairs.size());
    for_all_pieces([&](std::size_t piece, Index begin, Index rows) {
      auto mine = columns.middleRows(begin, rows);
      mine.col(place) = next.segment(begin, rows) - x.segment(begin, rows);
      mine.col(place + memory) = gradient.segment(begin, rows) - mine.col(at_gradient);
      mine.col(at_gradient) = gradient.segment(begin, rows);
      NewProducts& sums = of_piece[piece];
      int column = 0;
      for (const Index with : {place, place + memory, at_gradient}) {
        sums.col(column++).noalias() = mine.transpose() * mine.col(with);
      }
    });
    NewProducts sums = NewProducts::Zero();
    for (const NewProducts& some : of_piece) sums += some;
    int column = 0;
    for (const Index with : {place, place + memory, at_gradient}) {
      products.col(with) = sums.col(column);
      products.row(with) = sums.col(column++).transpose();
    }
    x.swap(next);
    value = next_value;
    if (full) pairs.erase(pairs.begin());
    const double product = products(place, place + memory);
    if (product * product >
            1e-24 * products(place, place) * products(place + memory, place + memory) &&
        product > 0.0) {
      pairs.push_back(place);
    } else if (full) {
      pairs.clear();  // its place is taken
    }
  }
  return value;
}

}  // namespace kappamu::forward
