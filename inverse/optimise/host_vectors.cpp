#include "inverse/optimise/host_vectors.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/numbers/widest.h"
#include "core/parallel.h"

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

std::vector<float> difference(const Vector& a, const Vector& b) {
  std::vector<float> result(a.size());
  for_pieces(a.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) result[i] = static_cast<float>(a[i] - b[i]);
  });
  return result;
}

}  // namespace

std::vector<double> HostVectors::products(std::size_t k) {
  const std::size_t kinds = 4 * (k + 1) + 1;
  std::vector<double> parts(pieces(state_.gradient.size()) * kinds, 0.0);
  for_blocks(state_.gradient.size(), [&](std::size_t piece, std::size_t begin, std::size_t end) {
    double* sum = parts.data() + piece * kinds;
    const float* const y = state_.changes[k].data() + begin;
    const double* const g = state_.gradient.data() + begin;
    const auto add = [&](const std::vector<float>& left) {
      const TwoSums sums = two_products(left.data() + begin, y, g, end - begin);
      *sum++ += sums.first;
      *sum++ += sums.second;
    };
    for (std::size_t j = 0; j <= k; ++j) {
      add(state_.steps[j]);
      add(state_.changes[j]);
    }
    const float* const s = state_.steps[k].data() + begin;
    *sum += two_products(s, s, g, end - begin).first;
  });
  return added_up(function_, parts, kinds);
}

double HostVectors::set_direction(const Combination& of) {
  const std::size_t size = state_.gradient.size();
  direction_.resize(size);
  std::vector<double> parts(pieces(size), 0.0);
  for_blocks(size, [&](std::size_t piece, std::size_t begin, std::size_t end) {
    double* const to = direction_.data() + begin;
    const double* const g = state_.gradient.data() + begin;
    const std::size_t count = end - begin;
    set_scaled(of.gradient, g, to, count);
    for (std::size_t k = 0; k < of.steps.size(); ++k) {
      if (of.steps[k] == 0.0 && of.changes[k] == 0.0) continue;
      add_pair(of.steps[k], state_.steps[k].data() + begin, of.changes[k],
               state_.changes[k].data() + begin, to, count);
    }
    for (std::size_t i = 0; i < count; ++i) parts[piece] += to[i] * g[i];
  });
  return added_up(function_, parts, 1).front();
}

double HostVectors::value_at(double length) {
  trial_ = state_.z;
  for_pieces(trial_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) trial_[i] += length * direction_[i];
  });
  return function_.value(trial_);
}

void HostVectors::accept() {
  direction_ = {};
  state_.steps.push_back(difference(trial_, state_.z));
  state_.z = std::exchange(trial_, {});
  const Vector before = std::move(state_.gradient);
  state_.gradient = function_.gradient();
  state_.changes.push_back(difference(state_.gradient, before));
}

void HostVectors::forget_pairs() {
  state_.steps.clear();
  state_.changes.clear();
}

void HostVectors::forget_oldest_pair() {
  state_.steps.erase(state_.steps.begin());
  state_.changes.erase(state_.changes.begin());
}

}  // namespace kappamu::inverse
