#include "inverse/problem/smooth_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"

namespace kappamu::inverse {

namespace {

/// 2 π f df cosines for each pixel lie between frequencies f and f + df, those of an octave of
/// variances 1/f² sum to this.
constexpr double per_octave = 2.0 * std::numbers::pi * std::numbers::ln2;

}  // namespace

SmoothErrorPrecision::SmoothErrorPrecision(const FaceShape& face, int patterns, double signal,
                                           const SmoothError& error)
    : patterns_(patterns),
      cosines_u_(face.nu),
      cosines_v_(face.nv),
      common_(face.nu, face.nv),
      own_(face.nu, face.nv) {
  // A constant has no frequency: that of half the lowest wave stands for it.
  const double lowest = 0.25 / static_cast<double>(face.cells());
  for (int v = 0; v < face.nv; ++v) {
    for (int u = 0; u < face.nu; ++u) {
      const double f2 =
          std::max(lowest, std::pow(0.5 * u / face.nu, 2) + std::pow(0.5 * v / face.nv, 2));
      const double scale = signal * signal / (per_octave * f2);
      const double own = scale * error.own * error.own;
      own_(u, v) = 1.0 / (1.0 + own);
      common_(u, v) = 1.0 / (1.0 + own + scale * patterns * error.common * error.common);
    }
  }
  common_root_ = common_.cwiseSqrt();
  own_root_ = own_.cwiseSqrt();
}

Eigen::MatrixXd SmoothErrorPrecision::filtered(const Eigen::MatrixXd& image,
                                               const Eigen::MatrixXd& by) const {
  return from_waves(cosines_u_, cosines_v_,
                    to_waves(cosines_u_, cosines_v_, image).cwiseProduct(by));
}

void SmoothErrorPrecision::filter(std::vector<double>& values, const Eigen::MatrixXd& common,
                                  const Eigen::MatrixXd& own) const {
  const Eigen::Index cells = own.size();
  const auto image = [&](int m) {
    return Eigen::Map<Eigen::MatrixXd>(values.data() + m * cells, own.rows(), own.cols());
  };
  Eigen::MatrixXd mean = image(0);
  for (int m = 1; m < patterns_; ++m) mean += image(m);
  mean /= patterns_;
  const Eigen::MatrixXd of_all = filtered(mean, common);
  for_rows(patterns_, [&](int m) { image(m) = of_all + filtered(image(m) - mean, own); });
}

}  // namespace kappamu::inverse
