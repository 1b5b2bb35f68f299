// A wrong size of the printed squares: what it does to the light's place, by geometry, and that a
// session tells it. The edge on seven rigs is in docs/limits.md; how often blocks of other kinds
// are accused of a shift is studies/limits/limits_consistency.cpp's to say.
#include "pipeline/stages/square_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "calib/projector/projector.h"
#include "io/read_file.h"
#include "tests/app/process.h"
#include "tests/app/tiny_session.h"

namespace kappamu::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double voxel_mm = 0.5;

/// A projector beside the camera, both before a slightly turned block of 20 x 16 x 6 voxels.
struct Rig {
  GridShape grid{20, 16, 6, voxel_mm};
  calib::CalibrationResult calibration;
  Rigid camera_from_sample;

  Rig() {
    calib::ProjectorCalibration& projector = calibration.projector;
    projector.lens = {640, 480, 2000.0, 2000.0, 320.0, 240.0, {0.05}};
    projector.projector_from_station.rotation =
        Eigen::AngleAxisd(0.25, Eigen::Vector3d::UnitY()).toRotationMatrix();
    projector.projector_from_station.translation = {-30.0, 6.0, 4.0};
    camera_from_sample.rotation =
        Eigen::AngleAxisd(0.1, Eigen::Vector3d(1.0, -1.0, 0.5).normalized()).toRotationMatrix();
    camera_from_sample.translation = {-5.0, -4.0, 120.0};
    calibration.projector_from_sample = projector.projector_from_station * camera_from_sample;
  }

  SurfaceMeasurements measurements() const {
    SurfaceMeasurements result;
    result.grid = grid;
    result.lit_face = Face::z_minus;
    result.seen_face = Face::z_plus;
    return result;
  }

  /// What the fit would find: images shifted by `shift` [mm], told from `limit` voxels on.
  static inverse::Consistency shifted(const Eigen::Vector3d& shift, double limit) {
    inverse::Consistency found;
    found.checked = true;
    found.shift_u = {shift.x() / voxel_mm, 0.1};
    found.shift_v = {shift.y() / voxel_mm, 0.1};
    found.shift_limit = limit;
    return found;
  }
};

TEST(SquareCheck, LightMovesAsItsBeamDoes) {
  const Rig rig;
  const Eigen::Vector3d middle(0.5 * 20 * voxel_mm, 0.5 * 16 * voxel_mm, 0.0);
  const calib::Lens& lens = rig.calibration.projector.lens;
  const Eigen::Vector2d told = lens.project(rig.calibration.projector_from_sample * middle);
  // Where that pixel's beam falls if the squares, and all that they scale, are larger by a little.
  constexpr double step = 1e-4;
  Rigid projector = rig.calibration.projector.projector_from_station;
  projector.translation *= 1.0 + step;
  const Eigen::Vector3d truly = calib::meet_plane(lens, projector * rig.camera_from_sample, told);
  const Eigen::Vector3d moved =
      light_shift_per_log_square(rig.calibration, rig.grid, Face::z_minus);
  EXPECT_LT(((truly - middle) / step - moved).norm(), 10.0 * step * moved.norm());
  EXPECT_GT(moved.norm(), 10.0);
}

TEST(SquareCheck, AShiftAlongTheLineTellsTheSize) {
  const Rig rig;
  const Eigen::Vector3d moved =
      light_shift_per_log_square(rig.calibration, rig.grid, Face::z_minus);
  const auto checked = [&rig](const Eigen::Vector3d& shift) {
    constexpr double limit = 0.6;  // voxels
    return *check_square_size(Rig::shifted(shift, limit), rig.calibration, rig.measurements());
  };
  const auto findings = [&rig](const std::vector<Eigen::Vector3d>& channels) {
    std::vector<inverse::Consistency> consistency;
    for (const Eigen::Vector3d& shift : channels) consistency.push_back(Rig::shifted(shift, 0.6));
    return check_shift(consistency, rig.calibration, rig.measurements());
  };
  const SquareSize larger = checked(0.03 * moved);
  EXPECT_NEAR(larger.log_factor.value, 0.03, 1e-9);
  EXPECT_TRUE(larger.explains);
  // The least shifted of two channels warns.
  const std::vector<ShiftFindings> both = findings({-0.04 * moved, -0.03 * moved});
  EXPECT_THAT(both[0].warnings, IsEmpty());
  EXPECT_THAT(both[1].warnings,
              ElementsAre(HasSubstr("check the sample pose"),
                          HasSubstr("about 3.0 % (standard deviation 0.3 %) smaller than "
                                    "calibration.board.square_mm")));
  EXPECT_THAT(findings({0.03 * moved})[0].warnings.back(), HasSubstr("larger than calibration"));
  // One across the line, which squares do not make; too small to tell, in one channel at least.
  const Eigen::Vector3d across(-moved.y(), moved.x(), 0.0);
  EXPECT_THAT(findings({0.03 * across})[0].warnings, ElementsAre(HasSubstr("sample pose")));
  for (const ShiftFindings& found : findings({0.03 * moved, 0.005 * moved})) {
    EXPECT_THAT(found.warnings, IsEmpty());
    EXPECT_THAT(found.notes, ElementsAre(HasSubstr("an error is reported beyond")));
  }
  EXPECT_FALSE(check_square_size({}, rig.calibration, rig.measurements()));
}

TEST(SquareCheck, ACameraThatLooksAslantComesFirst) {
  const Rig rig;
  const Eigen::Vector3d moved =
      light_shift_per_log_square(rig.calibration, rig.grid, Face::z_minus);
  const std::vector<inverse::Consistency> shifted{Rig::shifted(0.03 * moved, 0.6)};
  const Eigen::Vector3d middle(0.5 * 20 * voxel_mm, 0.5 * 16 * voxel_mm, 6 * voxel_mm);
  const auto warnings = [&](double degrees, double side) {
    SurfaceMeasurements measurements = rig.measurements();
    const double turn = degrees * std::numbers::pi / 180.0;
    measurements.cameras[Face::z_plus] =
        middle + 50.0 * (std::cos(turn) * Eigen::Vector3d::UnitZ() +
                         std::sin(turn) * side * moved.normalized());
    return check_shift(shifted, rig.calibration, measurements)[0].warnings;
  };
  EXPECT_THAT(warnings(25.0, 1.0), ElementsAre(HasSubstr("sample pose"),
                                               HasSubstr("from 25 degrees beside the normal")));
  for (const auto& others : {warnings(3.0, 1.0), warnings(25.0, -1.0)}) {
    EXPECT_THAT(others,
                ElementsAre(HasSubstr("sample pose"), HasSubstr("larger than calibration")));
  }
}

class SquareCheckTest : public TemporaryFolderTest {
 protected:
  /// Warnings of the red channel's fit with the squares told `factor` times as large.
  std::vector<std::string> warnings(double factor) const {
    const fs::path session = linked_session(folder() / "session");
    json description = json::parse(io::read_text(session / "session.json"));
    json& square = description["calibration"]["board"]["square_mm"];
    square = factor * square.get<double>();
    fs::remove(session / "session.json");
    std::ofstream(session / "session.json") << description.dump();
    const std::string run = (folder() / "run").string();
    for (const std::string& command :
         {"calibrate " + session.string() + " -o " + run,
          "merge " + session.string() + " -o " + run,
          "fit " + run + " -o " + run + "/fit --channel R --model homogeneous --uncertainty 0"}) {
      const ProcessResult result = kappamu(command + " --device reference");
      // Data that lie beside the light are not explained: the fit says so by its exit code.
      EXPECT_EQ(result.exit_code, command.starts_with("fit ") ? 3 : 0) << result.standard_error;
    }
    const json fit = json::parse(io::read_text(folder() / "run" / "fit" / "fit.json"));
    return fit["channels"][0]["warnings"].get<std::vector<std::string>>();
  }
};

TEST_F(SquareCheckTest, SquaresToldFivePercentTooLargeAreTold) {
  EXPECT_THAT(warnings(1.05), Contains(HasSubstr("smaller than calibration.board.square_mm")));
}

}  // namespace
}  // namespace kappamu::pipeline
