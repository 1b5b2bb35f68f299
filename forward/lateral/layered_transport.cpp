#include "forward/lateral/layered_transport.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>

#include "core/error.h"
#include "core/numbers/linear_algebra.h"
#include "forward/lateral/slides.h"

namespace kappamu::forward {

namespace {

using Complex = std::complex<double>;

/// Abscissas and weights of Gauss and Legendre on [-1, 1] (Golub and Welsch 1969).
struct Quadrature {
  Eigen::VectorXd at, weight;
};
Quadrature gauss_legendre(int points) {
  Eigen::MatrixXd jacobi = Eigen::MatrixXd::Zero(points, points);
  for (int i = 1; i < points; ++i) {
    jacobi(i, i - 1) = jacobi(i - 1, i) = i / std::sqrt(4.0 * i * i - 1.0);
  }
  const SymmetricEigen solved = symmetric_eigen(jacobi);
  return {solved.values, 2.0 * solved.vectors.row(0).transpose().array().square().matrix()};
}

/// Associated Legendre functions of the cosine c, l ≤ `order`, ∫ over [-1, 1] of each square 1.
std::map<std::pair<int, int>, double> legendre(int order, double c) {
  std::map<std::pair<int, int>, double> value;
  double highest = std::sqrt(0.5);
  for (int m = 0; m <= order; ++m) {
    if (m > 0) highest *= std::sqrt((1.0 - c * c) * (2.0 * m + 1.0) / (2.0 * m));
    const auto coupling = [m](int l) {
      return std::sqrt((static_cast<double>(l) * l - m * m) / (4.0 * l * l - 1.0));
    };
    double before = 0.0, here = highest;
    value[{m, m}] = here;
    for (int l = m + 1; l <= order; ++l) {
      const double back = l - 1 > m ? coupling(l - 1) * before : 0.0;
      before = std::exchange(here, (c * here - back) / coupling(l));
      value[{l, m}] = here;
    }
  }
  return value;
}

Eigen::MatrixXcd times(const Eigen::MatrixXd& matrix, const Eigen::MatrixXcd& right) {
  Eigen::MatrixXcd result(matrix.rows(), right.cols());
  result.real() = product(matrix, right.real());
  result.imag() = product(matrix, right.imag());
  return result;
}

constexpr int nodes = 48;
constexpr double least_absorption = 1e-8;  // over musp

}  // namespace

/// ψ of a layer: odd harmonics Σ over modes of exponentials, plus what the beam drives.
struct LayeredTransport::Modes {
  Eigen::MatrixXd even_by_odd;  ///< ψ_even = even_by_odd · ψ_odd' + of the beam
  Eigen::MatrixXcd shapes;      ///< odd, by mode
  Eigen::VectorXcd decay;       ///< [1/mm], real part > 0
  Eigen::VectorXd beam_odd, beam_even;
  double extinction = 0.0;  ///< of the beam [1/mm]
};

/// At one depth: odd and even harmonics by the modes' amplitudes, and of the beam.
struct LayeredTransport::Ends {
  Eigen::MatrixXcd odd, even;
  Eigen::VectorXcd beam_odd, beam_even;
};

LayeredTransport::LayeredTransport(double index, double anisotropy,
                                   std::optional<double> slide_index, int order)
    : anisotropy_(anisotropy), order_(order) {
  check(order >= 1 && order % 2 == 1 && anisotropy >= 0.0 && anisotropy < 1.0,
        "LayeredTransport: odd order, g in [0, 1)");
  for (int m = 0; m <= order; ++m) {
    for (int l = m; l <= order; ++l) ((l + m) % 2 == 0 ? even_ : odd_).push_back({l, m});
  }
  const auto evens = static_cast<Eigen::Index>(even_.size());
  const auto odds = static_cast<Eigen::Index>(odd_.size());
  along_ = Eigen::MatrixXd::Zero(evens, odds);
  for (Eigen::Index i = 0; i < evens; ++i) {
    for (Eigen::Index j = 0; j < odds; ++j) {
      const Harmonic& a = even_[static_cast<std::size_t>(i)];
      const Harmonic& b = odd_[static_cast<std::size_t>(j)];
      if (a.m != b.m || std::abs(a.l - b.l) != 1) continue;
      const double l = std::max(a.l, b.l);
      along_(i, j) = std::sqrt((l * l - a.m * a.m) / (4.0 * l * l - 1.0));
    }
  }
  across_even_ = across(even_);
  across_odd_ = across(odd_);

  escape_even_ = Eigen::MatrixXd::Zero(odds, evens);
  escape_odd_ = Eigen::MatrixXd::Zero(odds, odds);
  const Quadrature rule = gauss_legendre(nodes);
  const double critical = std::sqrt(std::max(0.0, 1.0 - 1.0 / (index * index)));
  const auto add = [&](double c, double weight) {
    const double reflected = slide_reflectance(index, slide_index.value_or(1.0), c);
    const auto value = legendre(order_, c);
    for (Eigen::Index i = 0; i < odds; ++i) {
      const Harmonic& a = odd_[static_cast<std::size_t>(i)];
      const auto against = [&](const Harmonic& b, double factor) {
        return a.m == b.m ? weight * factor * value.at({a.l, a.m}) * value.at({b.l, b.m}) : 0.0;
      };
      for (Eigen::Index j = 0; j < evens; ++j) {
        escape_even_(i, j) += against(even_[static_cast<std::size_t>(j)], 1.0 - reflected);
      }
      for (Eigen::Index j = 0; j < odds; ++j) {
        escape_odd_(i, j) += against(odd_[static_cast<std::size_t>(j)], 1.0 + reflected);
      }
    }
  };
  for (int k = 0; k < nodes; ++k) {
    const double s = 0.5 * (1.0 + rule.at[k]), weight = 0.5 * rule.weight[k];
    add(critical * s, critical * weight);
    // Above the critical angle R leaves 1 like a square root: c = critical + (1 − critical) s².
    add(critical + (1.0 - critical) * s * s, (1.0 - critical) * 2.0 * s * weight);
  }
}

/// Of s_x; with amplitudes ψ_lm = i^m χ_lm, i s_x is real and antisymmetric.
Eigen::MatrixXd LayeredTransport::across(const Harmonics& list) const {
  const auto size = static_cast<Eigen::Index>(list.size());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(size, size);
  const Quadrature rule = gauss_legendre(nodes);
  for (int k = 0; k < nodes; ++k) {
    const double c = rule.at[k], sine = std::sqrt(1.0 - c * c);
    const auto value = legendre(order_, c);
    for (Eigen::Index i = 0; i < size; ++i) {
      const Harmonic& a = list[static_cast<std::size_t>(i)];
      for (Eigen::Index j = 0; j < size; ++j) {
        const Harmonic& b = list[static_cast<std::size_t>(j)];
        if (b.m != a.m + 1) continue;
        const double azimuth = a.m == 0 ? std::numbers::sqrt2 / 2.0 : 0.5;
        const double part =
            rule.weight[k] * sine * azimuth * value.at({a.l, a.m}) * value.at({b.l, b.m});
        result(i, j) -= part;
        result(j, i) += part;
      }
    }
  }
  return result;
}

LayeredTransport::Modes LayeredTransport::modes_of(const TransportLayer& layer, double wave) const {
  const double peak = std::pow(anisotropy_, order_ + 1);
  const double scattering = layer.musp / (1.0 - anisotropy_) * (1.0 - peak);
  // Without absorption the mean has no equation of its own at wave 0.
  const double absorption = std::max(layer.mua, least_absorption * layer.musp);
  const auto moment = [&](int l) { return (std::pow(anisotropy_, l) - peak) / (1.0 - peak); };
  const auto system = [&](const Harmonics& list, const Eigen::MatrixXd& sideways) {
    Eigen::MatrixXd matrix = wave * sideways;
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
      matrix(i, i) += absorption + scattering * (1.0 - moment(list[static_cast<std::size_t>(i)].l));
    }
    return matrix;
  };
  const auto first_collisions = [&](const Harmonics& list) {
    Eigen::VectorXd source = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(list.size()));
    for (Eigen::Index i = 0; i < source.size(); ++i) {
      const Harmonic& at = list[static_cast<std::size_t>(i)];
      if (at.m > 0) continue;
      source[i] = scattering * moment(at.l) * std::sqrt((2.0 * at.l + 1.0) / 2.0) /
                  std::sqrt(2.0 * std::numbers::pi);
    }
    return source;
  };
  // along ψ_odd' + E ψ_even = S_even and alongᵀ ψ_even' + O ψ_odd = S_odd.
  const Eigen::MatrixXd even_system = system(even_, across_even_);
  const Eigen::MatrixXd odd_system = system(odd_, across_odd_);
  const Eigen::MatrixXd down = along_.transpose();
  // Both by one decomposition: ψ_even per ψ_odd', and of the beam where ψ_odd' = 0.
  Eigen::MatrixXd right(along_.rows(), along_.cols() + 1);
  right << along_, first_collisions(even_);
  const Eigen::MatrixXd solved = solve(even_system, right);
  const Eigen::MatrixXd driven = solved.leftCols(along_.cols());
  const Eigen::VectorXd even = solved.rightCols(1);
  const Eigen::MatrixXd stiffness = product(down, driven);
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(solve(stiffness, odd_system));
  Modes modes;
  modes.extinction = absorption + scattering;
  modes.even_by_odd = -driven;
  modes.shapes = solver.eigenvectors();
  modes.decay = solver.eigenvalues().array().sqrt();
  const double t = modes.extinction;
  modes.beam_odd =
      solve(t * t * stiffness - odd_system, -t * product(down, even) - first_collisions(odd_));
  modes.beam_even = even + t * product(driven, modes.beam_odd);
  return modes;
}

LayeredTransport::Ends LayeredTransport::ends_at(const Modes& modes, double thickness, double depth,
                                                 double beam) const {
  const Eigen::ArrayXcd falling = (-modes.decay.array() * depth).exp();
  const Eigen::MatrixXcd down = modes.shapes * falling.matrix().asDiagonal();
  const bool rises = std::isfinite(thickness);
  const Eigen::Index count = modes.decay.size();
  Ends ends;
  ends.odd.resize(count, rises ? 2 * count : count);
  Eigen::MatrixXcd slope(count, ends.odd.cols());
  ends.odd.leftCols(count) = down;
  slope.leftCols(count) = -down * modes.decay.asDiagonal();
  if (rises) {
    const Eigen::ArrayXcd rising = (-modes.decay.array() * (thickness - depth)).exp();
    ends.odd.rightCols(count) = modes.shapes * rising.matrix().asDiagonal();
    slope.rightCols(count) = ends.odd.rightCols(count) * modes.decay.asDiagonal();
  }
  ends.even = times(modes.even_by_odd, slope);
  const double left = beam * std::exp(-modes.extinction * depth);
  ends.beam_odd = (left * modes.beam_odd).cast<Complex>();
  ends.beam_even = (left * modes.beam_even).cast<Complex>();
  return ends;
}

LayeredLight LayeredTransport::operator()(std::span<const TransportLayer> layers,
                                          double frequency) const {
  check(!layers.empty(), "LayeredTransport: at least one layer");
  const double wave = 2.0 * std::numbers::pi * frequency;
  const auto odds = static_cast<Eigen::Index>(odd_.size());
  std::vector<Modes> modes;
  std::vector<double> beam{1.0};  // what reaches the top of each layer
  Eigen::Index unknowns = 0;
  std::vector<Eigen::Index> first;
  for (const TransportLayer& layer : layers) {
    modes.push_back(modes_of(layer, wave));
    first.push_back(unknowns);
    unknowns += std::isfinite(layer.thickness_mm) ? 2 * odds : odds;
    beam.push_back(beam.back() * std::exp(-modes.back().extinction * layer.thickness_mm));
  }
  const auto ends = [&](std::size_t i, double depth) {
    return ends_at(modes[i], layers[i].thickness_mm, depth, beam[i]);
  };
  Eigen::MatrixXcd matrix = Eigen::MatrixXcd::Zero(unknowns, unknowns);
  Eigen::VectorXcd right = Eigen::VectorXcd::Zero(unknowns);
  Eigen::Index row = 0;
  const auto surface = [&](const Ends& at, Eigen::Index column, double inwards) {
    matrix.block(row, column, odds, at.odd.cols()) =
        times(escape_even_, at.even) + inwards * times(escape_odd_, at.odd);
    right.segment(row, odds) =
        -(times(escape_even_, at.beam_even) + inwards * times(escape_odd_, at.beam_odd));
    row += odds;
  };
  const Eigen::MatrixXd down = along_.transpose();
  const Ends top = ends(0, 0.0);
  surface(top, 0, 1.0);
  for (std::size_t i = 0; i + 1 < layers.size(); ++i) {
    const Ends above = ends(i, layers[i].thickness_mm), below = ends(i + 1, 0.0);
    matrix.block(row, first[i], odds, above.odd.cols()) = above.odd;
    matrix.block(row, first[i + 1], odds, below.odd.cols()) = -below.odd;
    right.segment(row, odds) = below.beam_odd - above.beam_odd;
    row += odds;
    matrix.block(row, first[i], odds, above.odd.cols()) = times(down, above.even);
    matrix.block(row, first[i + 1], odds, below.odd.cols()) = -times(down, below.even);
    right.segment(row, odds) = times(down, below.beam_even - above.beam_even);
    row += odds;
  }
  const std::size_t last = layers.size() - 1;
  const bool slab = std::isfinite(layers[last].thickness_mm);
  const Ends bottom = ends(last, slab ? layers[last].thickness_mm : 0.0);
  if (slab) surface(bottom, first[last], -1.0);
  const Eigen::VectorXcd amplitude = matrix.partialPivLu().solve(right);
  Eigen::Index flux = 0;  // of Y_10
  while (odd_[static_cast<std::size_t>(flux)].l != 1 ||
         odd_[static_cast<std::size_t>(flux)].m != 0) {
    ++flux;
  }
  const auto flux_at = [&](const Ends& at, Eigen::Index column) {
    const Complex sum =
        (at.odd.row(flux) * amplitude.segment(column, at.odd.cols()))(0, 0) + at.beam_odd[flux];
    return std::sqrt(4.0 * std::numbers::pi / 3.0) * sum.real();
  };
  return {-flux_at(top, 0), slab ? flux_at(bottom, first[last]) + beam.back() : 0.0};
}

}  // namespace kappamu::forward
