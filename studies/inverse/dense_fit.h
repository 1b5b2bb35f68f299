// A fitted block small enough for dense matrices: the minimum of ½ χ² + α R and the covariance
// there, to say what a change of the data does to κ and μ, and to minimise again and see.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"
#include "inverse/problem/objective.h"
#include "inverse/regulariser/roughness.h"
#include "inverse/uncertainty/uncertainty.h"

namespace kappamu::studies {

/// Unknowns are log κ of every voxel, then log μ of every voxel; variances of each.
using Variances = Eigen::VectorXd;

class DenseFit {
 public:
  /// Fits `channel` as a volume by H1; its α and grid correction stay, and the minimum is found to
  /// rounding. Takes as many solves as there are unknowns, twice where that is far from where
  /// fit_channel() ended.
  DenseFit(const SurfaceMeasurements& measurements, int channel,
           const inverse::FitOptions& options);

  Eigen::Index unknowns() const { return fitted_.size(); }
  const Eigen::VectorXd& fitted() const { return fitted_; }
  const inverse::Prior& prior() const { return prior_; }             ///< α and lengths of R
  const Eigen::MatrixXd& jacobian() const { return jacobian_; }      ///< W^½ J [data][unknowns]
  const Eigen::MatrixXd& precision() const { return precision_; }    ///< α R″
  const Eigen::MatrixXd& covariance() const { return covariance_; }  ///< H⁻¹, H = JᵀWJ + α R″
  /// At the minimum's fields.
  inverse::Objective& objective();

  /// What the minimum moves by when the data become `data` [M][v][u], to first order: H⁻¹ JᵀW δd.
  Eigen::VectorXd change(const std::vector<double>& data) const;
  /// The same when light and values become those of `measurements`; weights stay.
  Eigen::VectorXd change(const SurfaceMeasurements& measurements);

  /// The minimum of the full objective with other data, or with other light and values, less
  /// fitted().
  Eigen::VectorXd refitted(const std::vector<double>& data);
  Eigen::VectorXd refitted(const SurfaceMeasurements& measurements);
  /// Largest ‖∇J‖ where those ended, against where they began.
  double unconverged() const { return unconverged_; }

  /// Variances of change() under independent errors of the values, with the variances that
  /// `measurements` states for them.
  Variances propagated(const SurfaceMeasurements& measurements) const;

 private:
  std::unique_ptr<inverse::Objective> exchanged(const SurfaceMeasurements& measurements) const;
  double value(inverse::Objective& objective, const std::vector<double>& data,
               const Eigen::VectorXd& u);
  Eigen::VectorXd gradient(inverse::Objective& objective, const std::vector<double>& data) const;
  Eigen::VectorXd minimise(inverse::Objective& objective, const std::vector<double>& data);
  void build_matrices();

  int channel_;
  inverse::FitOptions options_;
  inverse::Prior prior_;
  inverse::Anchor anchor_;
  std::unique_ptr<inverse::Objective> objective_;
  Eigen::VectorXd fitted_;
  Eigen::MatrixXd jacobian_, precision_, covariance_;
  inverse::CoefficientPair fields_;  ///< of the last value()
  double unconverged_ = 0.0;
};

/// u as fields, and back.
inverse::CoefficientPair fields_of(const Eigen::VectorXd& u);
Eigen::VectorXd joined(const inverse::CoefficientPair& fields);

}  // namespace kappamu::studies
