// How far predicted light is from measured light, relative to the measured: E of [W] 6.1. Against
// photographs it is the validation error, against noise-free light of a known volume the truth
// error.
#pragma once

#include <cstddef>

namespace kappamu {

/// Sums over light values L, predicted as L'; every sum has the unit of L².
struct AppearanceError {
  double misfit = 0.0;    ///< Σ(L' − L)²
  double signal = 0.0;    ///< ΣL²
  double noise = 0.0;     ///< Σσ²
  std::size_t count = 0;  ///< values

  void add(double predicted, double measured, double variance = 0.0);
  void add(const AppearanceError& other);

  /// Σ(L' − L)²/ΣL², dimensionless; 0 without light.
  double E() const;
  /// Σσ²/ΣL²: what noise alone makes of E.
  double noise_E() const;
};

}  // namespace kappamu
