#include "inverse/problem/smooth_error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/numbers/octave.h"
#include "core/parallel.h"

namespace kappamu::inverse {

SmoothErrorPrecision::SmoothErrorPrecision(const FaceShape& face, int patterns, double signal,
                                           const SmoothError& error,
                                           std::shared_ptr<const SharedMaps> shared)
    : patterns_(patterns),
      shared_(std::move(shared)),
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
      const double scale = signal * signal / octave_waves(f2);
      const double own = scale * error.own * error.own;
      own_(u, v) = 1.0 / (1.0 + own);
      common_(u, v) = 1.0 / (1.0 + own + scale * patterns * error.common * error.common);
    }
  }
  constant_ = common_(0, 0);
  common_root_ = common_.cwiseSqrt();
  own_root_ = own_.cwiseSqrt();
}

void SmoothErrorPrecision::hold_mean(bool held) {
  common_(0, 0) = held ? 1.0 : constant_;
  common_root_(0, 0) = std::sqrt(common_(0, 0));
}

Eigen::MatrixXd SmoothErrorPrecision::filtered(const Eigen::MatrixXd& image,
                                               const Eigen::MatrixXd& by) const {
  return from_waves(cosines_u_, cosines_v_,
                    to_waves(cosines_u_, cosines_v_, image).cwiseProduct(by));
}

void SmoothErrorPrecision::filter(std::vector<double>& values, const Eigen::MatrixXd& common,
                                  const Eigen::MatrixXd& own) const {
  std::vector<double> gathered;
  if (shared_) gathered = shared_->whole(values);
  std::vector<double>& maps = shared_ ? gathered : values;
  const Eigen::Index cells = own.size();
  const int here = static_cast<int>(static_cast<Eigen::Index>(maps.size()) / cells);
  const auto image = [&](int m) {
    return Eigen::Map<Eigen::MatrixXd>(maps.data() + m * cells, own.rows(), own.cols());
  };
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(own.rows(), own.cols());
  for (int m = 0; m < here; ++m) mean += image(m);
  if (shared_) shared_->sum(mean);
  mean /= patterns_;
  const Eigen::MatrixXd of_all = filtered(mean, common);
  for_rows(here, [&](int m) { image(m) = of_all + filtered(image(m) - mean, own); });
  if (shared_) shared_->take_part(maps, values);
}

std::vector<OctaveMisfit> SmoothErrorPrecision::octaves(
    const std::vector<double>& residuals) const {
  std::vector<double> gathered;
  if (shared_) gathered = shared_->whole(residuals);
  const std::vector<double>& maps = shared_ ? gathered : residuals;
  const Eigen::Index cells = own_.size();
  std::vector<Eigen::MatrixXd> waves(maps.size() / static_cast<std::size_t>(cells));
  for_rows(static_cast<int>(waves.size()), [&](int m) {
    const Eigen::Map<const Eigen::MatrixXd> image(maps.data() + m * cells, own_.rows(),
                                                  own_.cols());
    waves[static_cast<std::size_t>(m)] = to_waves(cosines_u_, cosines_v_, image);
  });
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(own_.rows(), own_.cols());
  Eigen::MatrixXd mean = squares;
  for (const Eigen::MatrixXd& pattern : waves) {
    mean += pattern / patterns_;
    squares += pattern.cwiseAbs2();
  }
  if (shared_) {
    shared_->sum(mean);
    shared_->sum(squares);
  }
  const Eigen::MatrixXd of_mean = patterns_ * mean.cwiseAbs2();
  const double longest = 2.0 * static_cast<double>(std::max(own_.rows(), own_.cols()));
  std::vector<OctaveMisfit> found;
  for (Eigen::Index v = 0; v < own_.cols(); ++v) {
    for (Eigen::Index u = 0; u < own_.rows(); ++u) {
      const bool constant = u == 0 && v == 0;
      const double waves_across = longest * std::hypot(0.5 * static_cast<double>(u) / own_.rows(),
                                                       0.5 * static_cast<double>(v) / own_.cols());
      const int octave = constant ? 0 : 1 + static_cast<int>(std::log2(waves_across) + 1e-9);
      while (static_cast<int>(found.size()) < 2 * (octave + 1)) {
        const auto k = static_cast<double>(found.size() / 2);
        const double period = k == 0.0 ? 0.0 : longest / std::exp2(k - 1.0);
        found.push_back({true, period});
        found.push_back({false, period});
      }
      OctaveMisfit& all = found[2 * static_cast<std::size_t>(octave)];
      OctaveMisfit& each = found[2 * static_cast<std::size_t>(octave) + 1];
      all.values += 1.0;
      all.chi2 += (constant ? constant_ : common_(u, v)) * of_mean(u, v);
      each.values += patterns_ - 1;
      each.chi2 += own_(u, v) * (squares(u, v) - of_mean(u, v));
    }
  }
  std::erase_if(found, [](const OctaveMisfit& octave) { return octave.values == 0.0; });
  return found;
}

}  // namespace kappamu::inverse
