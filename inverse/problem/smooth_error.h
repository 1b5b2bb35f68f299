// Errors that neighbouring pixels have in common: of scale, response, light and pose, of pixels
// that are not equally sensitive, and of the model itself. Noise that is taken for white trusts the
// data's long waves far beyond what any photograph is good for: the mean of 16 patterns of 128²
// pixels with 0.2 % noise each would be known to 4e-6. Photographs of the simulated rig differ from
// their truth by 2 to 8e-4 in every octave of spatial frequency (docs/theory.md, section 4).
//
// The covariance of residuals in their own standard deviations is I + S, S diagonal in the cosines
// of the face and in the patterns' mean and what is left of each:
//   S = q² e² / (2 π ln 2 f²), q² the mean of (d/σ)², f the wave's frequency [1/pixel],
// which gives every octave the size e relative to d; e² is own², and own² + M common² for the mean.
//
// The mean of all light is one wave among all, and the one that a regulariser trades in first:
// darker everywhere, a block shows the same structure of κ with less of it. So fits hold it to its
// noise, while what they state of their errors counts S of it too (docs/theory.md, section 4).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/grid.h"
#include "core/numbers/cosine_transform.h"
#include "core/surface_measurements.h"

namespace kappamu::inverse {

/// χ² of the waves of an octave of frequency, each by its own variance: of the patterns' mean, or
/// of what is left of each.
struct OctaveMisfit {
  bool of_mean = false;
  double longest = 0.0;  ///< period [pixels]; 0: the constant
  double values = 0.0;   ///< waves times patterns that they vary in
  double chi2 = 0.0;     ///< of all of them
};

/// Maps [M][v][u] of a face that several processes share.
class SharedMaps {
 public:
  virtual ~SharedMaps() = default;
  /// Whole maps, some of the M, of what each process has of all of them; and back.
  virtual std::vector<double> whole(const std::vector<double>& part) const = 0;
  virtual void take_part(const std::vector<double>& whole, std::vector<double>& part) const = 0;
  /// Over all processes.
  virtual void sum(Eigen::MatrixXd& image) const = 0;
};

/// (I + S)⁻¹ of residuals [M][v][u] on one face.
class FaceErrorPrecision {
 public:
  /// `signal` is q. With `shared` residuals are this process's part of the maps of `face`, and
  /// every call is all processes'.
  FaceErrorPrecision(const FaceShape& face, int patterns, double signal, const SmoothError& error,
                     std::shared_ptr<const SharedMaps> shared = nullptr);

  /// Whether the constant of the patterns' mean counts by its noise alone, in place of I + S.
  void hold_mean(bool held);

  void apply(std::vector<double>& residuals) const { filter(residuals, common_, own_); }
  /// Its square root: white numbers become residuals of this precision.
  void apply_root(std::vector<double>& white) const { filter(white, common_root_, own_root_); }
  /// χ² of every octave by I + S, the mean held or not; octaves without values are left out.
  std::vector<OctaveMisfit> octaves(const std::vector<double>& residuals) const;

 private:
  void filter(std::vector<double>& values, const Eigen::MatrixXd& common,
              const Eigen::MatrixXd& own) const;
  Eigen::MatrixXd filtered(const Eigen::MatrixXd& image, const Eigen::MatrixXd& by) const;

  int patterns_;
  std::shared_ptr<const SharedMaps> shared_;
  CosineTransform cosines_u_;
  CosineTransform cosines_v_;
  Eigen::MatrixXd common_;  ///< by frequency [u][v]
  Eigen::MatrixXd own_;
  Eigen::MatrixXd common_root_;
  Eigen::MatrixXd own_root_;
  double constant_;  ///< of the mean, by I + S
};

struct PicturesOfFace {
  std::vector<int> pictures;  ///< numbers of the M
  double signal = 0.0;        ///< q of them
};

/// The same of pictures of one face or of two, whose errors have nothing in common.
class SmoothErrorPrecision {
 public:
  SmoothErrorPrecision(const FaceShape& face, int patterns, double signal, const SmoothError& error,
                       std::shared_ptr<const SharedMaps> shared = nullptr);
  SmoothErrorPrecision(const FaceShape& face, std::vector<PicturesOfFace> faces,
                       const SmoothError& error);

  void hold_mean(bool held);
  void apply(std::vector<double>& residuals) const;
  void apply_root(std::vector<double>& white) const;
  std::vector<OctaveMisfit> octaves(const std::vector<double>& residuals) const;

 private:
  struct Part {
    std::vector<int> pictures;  ///< empty: all
    FaceErrorPrecision precision;
  };
  template <class Use>
  void for_parts(std::vector<double>& maps, const Use& use) const;

  std::size_t cells_;
  std::vector<Part> parts_;
};

}  // namespace kappamu::inverse
