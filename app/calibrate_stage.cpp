#include "app/calibrate_stage.h"

#include "calib/calibrate.h"
#include "calib/calibration_file.h"

namespace kappamu::app {

namespace fs = std::filesystem;

void run_calibrate_stage(const capture::Session& session, const capture::HdrOptions& hdr,
                         const fs::path& run, Progress& progress) {
  const calib::CalibrationResult result = calib::calibrate(session, progress, hdr);
  const fs::path partial = run / "calibration.partial";
  fs::remove_all(partial);
  calib::save_calibration(partial, result);
  fs::remove_all(run / "calibration");
  fs::rename(partial, run / "calibration");
}

}  // namespace kappamu::app
