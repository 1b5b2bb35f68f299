// Amounts of absorbers and the law of scattering, from μa and σs' at several wavelengths: at each
// pixel of a map by itself.
#pragma once

#include <Eigen/Core>

namespace kappamu::inverse {

inline constexpr int most_absorbers = 8;

/// `spectra` has a column by absorber (at most most_absorbers, and at most as many as wavelengths).
struct AmountFit {
  Eigen::VectorXd amount;      ///< by absorber, not negative
  Eigen::MatrixXd covariance;  ///< of the fit without that bound
  double chi_square = 0.0;

  double deviation(Eigen::Index absorber) const;  ///< standard
};

/// True where each absorber's spectrum differs from the others' at these wavelengths.
bool distinct(const Eigen::MatrixXd& spectra);

/// Weighted non-negative least squares of `absorption` [1/mm] with standard `deviation`; errors of
/// wavelengths are taken as independent. `spectra` are distinct().
AmountFit fit_amounts(const Eigen::MatrixXd& spectra, const Eigen::VectorXd& absorption,
                      const Eigen::VectorXd& deviation);

/// σs'(λ) = A (λ/500 nm)^-b (Jacques, Phys. Med. Biol. 58, R37, 2013, eq. 1).
struct ScatteringLaw {
  double at_500nm = 0.0, exponent = 0.0;  ///< A [1/mm], b
  double at_500nm_deviation = 0.0, exponent_deviation = 0.0;
};

/// Two wavelengths or more; `scattering` and its standard `deviation` are positive.
ScatteringLaw fit_scattering_law(const Eigen::VectorXd& wavelength_nm,
                                 const Eigen::VectorXd& scattering,
                                 const Eigen::VectorXd& deviation);

}  // namespace kappamu::inverse
