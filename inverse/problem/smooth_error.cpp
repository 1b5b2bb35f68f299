#include "inverse/problem/smooth_error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/numbers/octave.h"
#include "core/parallel.h"

namespace kappamu::inverse {

FaceErrorPrecision::FaceErrorPrecision(const FaceShape& face, int patterns, double signal,
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

void FaceErrorPrecision::hold_mean(bool held) {
  common_(0, 0) = held ? 1.0 : constant_;
  common_root_(0, 0) = std::sqrt(common_(0, 0));
}

Eigen::MatrixXd FaceErrorPrecision::filtered(const Eigen::MatrixXd& image,
                                             const Eigen::MatrixXd& by) const {
  return from_waves(cosines_u_, cosines_v_,
                    to_waves(cosines_u_, cosines_v_, image).cwiseProduct(by));
}

void FaceErrorPrecision::filter(std::vector<double>& values, const Eigen::MatrixXd& common,
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

std::vector<OctaveMisfit> FaceErrorPrecision::octaves(const std::vector<double>& residuals) const {
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

SmoothErrorPrecision::SmoothErrorPrecision(const FaceShape& face, int patterns, double signal,
                                           const SmoothError& error,
                                           std::shared_ptr<const SharedMaps> shared)
    : cells_(face.cells()) {
  parts_.push_back({{}, {face, patterns, signal, error, std::move(shared)}});
}

SmoothErrorPrecision::SmoothErrorPrecision(const FaceShape& face, std::vector<PicturesOfFace> faces,
                                           const SmoothError& error)
    : cells_(face.cells()) {
  for (PicturesOfFace& of_face : faces) {
    const int count = static_cast<int>(of_face.pictures.size());
    if (faces.size() == 1) of_face.pictures.clear();
    parts_.push_back({std::move(of_face.pictures), {face, count, of_face.signal, error}});
  }
}

/// Calls use(precision, maps) with the maps of each part, and keeps what it makes of them.
template <class Use>
void SmoothErrorPrecision::for_parts(std::vector<double>& maps, const Use& use) const {
  for (const Part& part : parts_) {
    if (part.pictures.empty()) {
      use(part.precision, maps);
      continue;
    }
    const auto map = [&](int m) { return maps.begin() + m * static_cast<std::ptrdiff_t>(cells_); };
    std::vector<double> own;
    for (const int m : part.pictures) own.insert(own.end(), map(m), map(m + 1));
    use(part.precision, own);
    for (std::size_t k = 0; k < part.pictures.size(); ++k) {
      std::copy_n(own.begin() + static_cast<std::ptrdiff_t>(k * cells_), cells_,
                  map(part.pictures[k]));
    }
  }
}

void SmoothErrorPrecision::hold_mean(bool held) {
  for (Part& part : parts_) part.precision.hold_mean(held);
}

void SmoothErrorPrecision::apply(std::vector<double>& residuals) const {
  for_parts(residuals, [](const FaceErrorPrecision& of_face, std::vector<double>& maps) {
    of_face.apply(maps);
  });
}

void SmoothErrorPrecision::apply_root(std::vector<double>& white) const {
  for_parts(white, [](const FaceErrorPrecision& of_face, std::vector<double>& maps) {
    of_face.apply_root(maps);
  });
}

std::vector<OctaveMisfit> SmoothErrorPrecision::octaves(
    const std::vector<double>& residuals) const {
  std::vector<OctaveMisfit> all;
  std::vector<double> maps = residuals;
  for_parts(maps, [&](const FaceErrorPrecision& of_face, const std::vector<double>& own) {
    for (const OctaveMisfit& octave : of_face.octaves(own)) all.push_back(octave);
  });
  return all;
}

}  // namespace kappamu::inverse
