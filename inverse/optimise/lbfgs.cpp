#include "inverse/optimise/lbfgs.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/numbers/widest.h"
#include "core/parallel.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

/// Elements of which all vectors are taken in turn: the gradient's and the direction's stay in
/// caches of the second level.
constexpr std::size_t block_length = 4096;

constexpr std::size_t in_register = 4;
// NOLINTNEXTLINE: of numbers in any place, unlike a vector by itself
typedef double Lanes
    __attribute__((vector_size(in_register * sizeof(double)), aligned(8), may_alias));
// NOLINTNEXTLINE
typedef float Halves
    __attribute__((vector_size(in_register * sizeof(float)), aligned(4), may_alias));

struct TwoSums {
  double first = 0.0, second = 0.0;
};

/// Sums of left · a and of left · b.
KAPPAMU_WIDEST TwoSums two_products(const float* left, const float* a, const double* b,
                                    std::size_t count) {
  Lanes of_a[2] = {}, of_b[2] = {};
  std::size_t i = 0;
  for (; i + 2 * in_register <= count; i += 2 * in_register) {
    for (std::size_t k = 0; k < 2; ++k) {
      const std::size_t at = i + k * in_register;
      const Lanes l = __builtin_convertvector(*reinterpret_cast<const Halves*>(left + at), Lanes);
      of_a[k] += l * __builtin_convertvector(*reinterpret_cast<const Halves*>(a + at), Lanes);
      of_b[k] += l * *reinterpret_cast<const Lanes*>(b + at);
    }
  }
  const Lanes first = of_a[0] + of_a[1], second = of_b[0] + of_b[1];
  TwoSums sums{(first[0] + first[1]) + (first[2] + first[3]),
               (second[0] + second[1]) + (second[2] + second[3])};
  for (; i < count; ++i) {
    const auto l = static_cast<double>(left[i]);
    sums.first += l * static_cast<double>(a[i]);
    sums.second += l * b[i];
  }
  return sums;
}

/// to += s · step + y · change.
KAPPAMU_WIDEST void add_pair(double s, const float* step, double y, const float* change, double* to,
                             std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    to[i] += s * static_cast<double>(step[i]) + y * static_cast<double>(change[i]);
  }
}

KAPPAMU_WIDEST void set_scaled(double factor, const double* from, double* to, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) to[i] = factor * from[i];
}

/// Calls work(piece, begin, end) for blocks of every piece of a vector, in order within a piece.
template <class Work>
void for_blocks(std::size_t size, const Work& work) {
  for_pieces(size, [&](std::size_t piece, std::size_t begin, std::size_t end) {
    for (std::size_t at = begin; at < end; at += block_length) {
      work(piece, at, std::min(end, at + block_length));
    }
  });
}

/// Sums over all pieces, [piece][kind] to [kind], and of all processes.
std::vector<double> added_up(const Function& function, const std::vector<double>& parts,
                             std::size_t kinds) {
  std::vector<double> sums(kinds, 0.0);
  for (std::size_t i = 0; i < parts.size(); ++i) sums[i % kinds] += parts[i];
  function.total(sums);
  return sums;
}

/// Products of the gradient with steps and changes.
struct AlongGradient {
  std::vector<double> steps, changes;
};

/// Sets products[k] and returns those of the gradient with the pairs up to k.
AlongGradient multiply(const Function& function, OptimiserState& state, std::size_t k) {
  const std::size_t kinds = 4 * (k + 1) + 1;
  std::vector<double> parts(pieces(state.gradient.size()) * kinds, 0.0);
  for_blocks(state.gradient.size(), [&](std::size_t piece, std::size_t begin, std::size_t end) {
    double* sum = parts.data() + piece * kinds;
    const float* const y = state.changes[k].data() + begin;
    const double* const g = state.gradient.data() + begin;
    const auto add = [&](const std::vector<float>& left) {
      const TwoSums sums = two_products(left.data() + begin, y, g, end - begin);
      *sum++ += sums.first;
      *sum++ += sums.second;
    };
    for (std::size_t j = 0; j <= k; ++j) {
      add(state.steps[j]);
      add(state.changes[j]);
    }
    const float* const s = state.steps[k].data() + begin;
    *sum += two_products(s, s, g, end - begin).first;
  });
  const std::vector<double> sums = added_up(function, parts, kinds);
  AlongGradient along;
  LbfgsProducts products;
  for (std::size_t j = 0; j <= k; ++j) {
    products.by_step.push_back(sums[4 * j]);
    along.steps.push_back(sums[4 * j + 1]);
    products.by_change.push_back(sums[4 * j + 2]);
    along.changes.push_back(sums[4 * j + 3]);
  }
  products.step_square = sums.back();
  state.products.resize(k + 1);
  state.products[k] = std::move(products);
  return along;
}

/// gradient · g + Σ steps[k] s_k + changes[k] y_k, over all pairs.
struct Combination {
  double gradient = -1.0;
  std::vector<double> steps, changes;
};

Descent combined(const Function& function, const OptimiserState& state, const Combination& of) {
  const std::size_t size = state.gradient.size();
  Descent descent{Vector(size), 0.0};
  std::vector<double> parts(pieces(size), 0.0);
  for_blocks(size, [&](std::size_t piece, std::size_t begin, std::size_t end) {
    double* const to = descent.direction.data() + begin;
    const double* const g = state.gradient.data() + begin;
    const std::size_t count = end - begin;
    set_scaled(of.gradient, g, to, count);
    for (std::size_t k = 0; k < of.steps.size(); ++k) {
      if (of.steps[k] == 0.0 && of.changes[k] == 0.0) continue;
      add_pair(of.steps[k], state.steps[k].data() + begin, of.changes[k],
               state.changes[k].data() + begin, to, count);
    }
    for (std::size_t i = 0; i < count; ++i) parts[piece] += to[i] * g[i];
  });
  descent.slope = added_up(function, parts, 1).front();
  return descent;
}

/// Pairs whose curvature is positive beyond rounding.
std::vector<std::size_t> usable_pairs(const std::vector<LbfgsProducts>& products) {
  std::vector<std::size_t> usable;
  for (std::size_t k = 0; k < products.size(); ++k) {
    const LbfgsProducts& p = products[k];
    if (p.curvature() > 1e-10 * std::sqrt(p.step_square * p.change_square())) usable.push_back(k);
  }
  return usable;
}

}  // namespace

Descent steepest_descent(const Function& function, const OptimiserState& state) {
  return combined(function, state, {});
}

Descent lbfgs_descent(const Function& function, OptimiserState& state) {
  const std::size_t pairs = state.steps.size();
  if (pairs == 0) return steepest_descent(function, state);
  AlongGradient along;
  for (std::size_t k = std::min(state.products.size(), pairs - 1); k < pairs; ++k) {
    along = multiply(function, state, k);
  }
  const std::vector<LbfgsProducts>& products = state.products;
  const std::vector<std::size_t> usable = usable_pairs(products);
  if (usable.empty()) return steepest_descent(function, state);
  const std::size_t count = usable.size();
  std::vector<double> alpha(count), beta(count);
  for (std::size_t k = count; k-- > 0;) {
    double product = along.steps[usable[k]];
    for (std::size_t j = k + 1; j < count; ++j) {
      product -= alpha[j] * products[usable[j]].by_step[usable[k]];
    }
    alpha[k] = product / products[usable[k]].curvature();
  }
  const LbfgsProducts& newest = products[usable.back()];
  const double scale = defaults::optimiser::softer * newest.curvature() / newest.change_square();
  for (std::size_t k = 0; k < count; ++k) {
    const LbfgsProducts& own = products[usable[k]];
    double product = along.changes[usable[k]];
    for (std::size_t j = 0; j < count; ++j) {
      const auto [older, newer] = std::minmax(usable[j], usable[k]);
      product -= alpha[j] * products[newer].by_change[older];
    }
    product *= scale;
    for (std::size_t j = 0; j < k; ++j) product += beta[j] * own.by_step[usable[j]];
    beta[k] = alpha[k] - product / own.curvature();
  }
  Combination of{-scale, std::vector<double>(pairs, 0.0), std::vector<double>(pairs, 0.0)};
  for (std::size_t k = 0; k < count; ++k) {
    of.steps[usable[k]] = -beta[k];
    of.changes[usable[k]] = scale * alpha[k];
  }
  return combined(function, state, of);
}

}  // namespace kappamu::inverse
