// From demodulated light to reflectance: by a phantom of known coefficients or an absolute scale,
// and the errors that all pixels share.
#pragma once

#include <utility>
#include <vector>

#include "forward/lateral/lateral_reflectance.h"
#include "inverse/lateral/lateral_fit.h"
#include "pipeline/records/sfdi_maps.h"
#include "pipeline/sfdi/sfdi_file.h"

namespace kappamu::pipeline::sfdi {

/// The forward model as stated, and at one deviation of n, of g and of a known layer's
/// coefficients, in this order.
struct Models {
  /// Throws InputError, naming `file`, outside a layer's wavelengths.
  Models(const Medium& medium, double wavelength_nm, const std::string& file);

  forward::LateralReflectance stated;
  std::vector<forward::LateralReflectance> shifted;
};

class Calibration {
 public:
  /// Of one wavelength and its spatial frequencies [1/mm].
  Calibration(const Description& description, double wavelength_nm,
              const inverse::PerFrequency& frequency, const inverse::FarSides& far = {});

  /// Reflectance of the phantom per frequency; with an absolute scale, 1 over it.
  const inverse::PerFrequency& scale() const { return scale_; }
  const Models& sample() const { return sample_; }

  /// Relative variances and, by ln μa and ln σs', covariance of what is shared by all pixels.
  struct Shared {
    std::array<Eigen::Matrix2d, part_names.size()> covariance;
    Eigen::Matrix2d total() const;
  };
  /// At a fitted pixel; the parts `noise` and `detail` stay zero.
  Shared shared_errors(const inverse::LateralFit& fit) const;
  /// The same errors of ln R by frequency, about a medium.
  Eigen::MatrixXd log_covariance(const inverse::LateralCoefficients& at) const;

 private:
  /// Errors of ln R that are independent of one another, with their causes.
  std::vector<std::pair<Part, inverse::PerFrequency>> log_errors(
      const inverse::LateralCoefficients& at) const;
  inverse::PerFrequency logarithms(const forward::LateralReflectance& model,
                                   const inverse::LateralCoefficients& at) const;

  double table_error(const forward::LateralReflectance& model, Eigen::Index i,
                     const inverse::LateralCoefficients& at) const;

  inverse::PerFrequency frequency_, scale_;
  inverse::FarSides far_;
  Errors errors_;
  Models sample_;
  bool by_phantom_ = false;
  std::vector<inverse::PerFrequency> phantom_errors_;  ///< change of ln R at one deviation
  std::vector<inverse::PerFrequency> phantom_shifts_;  ///< of ln R, for n and g
  inverse::PerFrequency phantom_table_;                ///< relative error of R
};

}  // namespace kappamu::pipeline::sfdi
