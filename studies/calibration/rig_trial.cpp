#include "studies/calibration/rig_trial.h"

#include <Eigen/Eigenvalues>

#include "calib/lens/lens_model.h"
#include "calib/lens/pose_numbers.h"
#include "capture/radiance/merge.h"
#include "core/error.h"
#include "data_synthetic/simulate.h"
#include "io/image/image_file.h"
#include "studies/calibration/rig_corners.h"

namespace kappamu::studies {

namespace {

/// Zero-mean normal numbers of a covariance whose units differ by row: the root is taken of the
/// correlations. Rows of what is held are 0.
Eigen::VectorXd normal(const Eigen::MatrixXd& covariance, std::mt19937_64& random) {
  const Eigen::VectorXd deviation = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  Eigen::MatrixXd correlation = covariance;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    for (Eigen::Index j = 0; j < covariance.cols(); ++j) {
      const double scale = deviation[i] * deviation[j];
      correlation(i, j) = scale > 0.0 ? covariance(i, j) / scale : 0.0;
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  std::normal_distribution<double> unit;
  Eigen::VectorXd values(covariance.rows());
  for (double& value : values) value = unit(random);
  const Eigen::VectorXd root = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return deviation.cwiseProduct(eigen.eigenvectors() * root.cwiseProduct(values));
}

calib::Lens moved(const calib::Lens& lens, calib::LensModel model, const Eigen::VectorXd& by) {
  calib::LensNumbers numbers = calib::numbers_of(lens);
  for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] += by[static_cast<Eigen::Index>(k)];
  return calib::lens_of(numbers, calib::pixel_shape(model), lens.width, lens.height);
}

}  // namespace

Lenses true_lenses(const synthetic::Truth& truth) {
  return {
      truth.camera_lens, truth.projector.lens,
      truth.projector.projector_from_world * truth.world_from_camera.at(truth.calibration_station)};
}

Lenses drawn(const calib::JointCalibration& joint, std::mt19937_64& random) {
  // Order of JointCalibration::covariance; where the boards stood is of no further use.
  constexpr Eigen::Index lens = calib::lens_numbers;
  constexpr Eigen::Index bend = 2;
  constexpr Eigen::Index pose = 6;
  const Eigen::VectorXd by = normal(
      joint.covariance.topLeftCorner(2 * lens + bend + pose, 2 * lens + bend + pose), random);
  std::array<double, 6> six = calib::six_of(joint.projector.projector_from_station);
  for (std::size_t k = 0; k < six.size(); ++k)
    six[k] += by.tail(pose)[static_cast<Eigen::Index>(k)];
  return {moved(joint.camera.lens, joint.camera.model, by.head(lens)),
          moved(joint.projector.lens, joint.projector.model, by.segment(lens + bend, lens)),
          calib::rigid_of(six)};
}

calib::JointCalibration calibrate_corners(const synthetic::Rig& rig, double noise_px,
                                          std::mt19937_64& random) {
  const RigCorners corners = seen_corners(rig, noise_px, random);
  const calib::CameraCalibration camera = calib::calibrate_camera(
      corners.views, rig.board.square_mm, rig.camera_lens.width, rig.camera_lens.height);
  const calib::ProjectorCalibration projector =
      calib::calibrate_projector(camera.lens, rig.board, rig.projected_board, corners.planes,
                                 rig.projector.lens.width, rig.projector.lens.height);
  return calib::adjust_jointly({corners.views, rig.board, rig.projected_board, corners.planes},
                               camera, projector);
}

RigTrial::RigTrial(const synthetic::SimulationOptions& options, const std::filesystem::path& folder,
                   const std::string& device, Progress& progress)
    : truth_folder_(folder / "truth") {
  if (!std::filesystem::exists(truth_folder_ / "truth.json")) {
    synthetic::simulate(options, folder, device, progress);
  }
  session_ = capture::read_session(folder / "session");
  session_.calibration.colour_chart.reset();  // a check, and slow to find
  truth_ = synthetic::read_truth(truth_folder_);
  calibration_ = calib::calibrate(session_, progress);
  merge();
}

void RigTrial::merge() {
  for (const capture::Pattern& pattern : session_.patterns) {
    pictures_[pattern.id] =
        capture::merge_stack(session_, pattern.frames, pattern.id, calibration_.radiometry);
  }
}

RigTrial RigTrial::with_exposures(int count) const {
  RigTrial fewer = *this;
  for (capture::Pattern& pattern : fewer.session_.patterns) {
    const std::size_t steps = pattern.frames.size() - 1;
    const auto taken = static_cast<std::size_t>(count) - 1;
    check(taken > 0 && steps % taken == 0, "exposures are evenly taken from those there are");
    capture::Stack frames;
    for (std::size_t k = 0; k <= taken; ++k) frames.push_back(pattern.frames[k * steps / taken]);
    pattern.frames = frames;
  }
  Progress silent;
  fewer.calibration_.radiometry = capture::find_radiometry(fewer.session_, silent);
  calib::calibrate_sample(fewer.session_, fewer.calibration_, silent);
  fewer.merge();
  return fewer;
}

calib::CalibrationResult RigTrial::calibrated(const Lenses& lenses) const {
  calib::CalibrationResult result = calibration_;
  result.camera.lens = lenses.camera;
  result.projector.lens = lenses.projector;
  result.projector.projector_from_station = lenses.projector_from_station;
  Progress silent;
  calib::calibrate_sample(session_, result, silent);
  return result;
}

SurfaceMeasurements RigTrial::measured(const calib::CalibrationResult& calibration,
                                       const calib::MeasureOptions& options) const {
  Progress silent;
  return calib::measure_surface(
      session_, calibration, capture::PatternRole::fit,
      [this](const std::string& id) { return pictures_.at(id); }, silent, options);
}

SurfaceMeasurements RigTrial::exact(calib::CalibrationResult calibration) const {
  calibration.scale.assign(truth_.responsivity.begin(), truth_.responsivity.end());
  Progress silent;
  return calib::measure_surface(
      session_, calibration, capture::PatternRole::fit,
      [this](const std::string& id) {
        capture::HdrImage picture = pictures_.at(id);
        picture.radiance = io::read_float_image(truth_folder_ / "radiance" / (id + ".exr"));
        return picture;
      },
      silent);
}

}  // namespace kappamu::studies
