#include "app/calibrate_stage.h"

#include "calib/calibrate.h"
#include "calib/calibration_file.h"
#include "capture/chart_search.h"

namespace kappamu::app {

namespace fs = std::filesystem;

namespace {

/// The session with the chart's place filled in where mcc finds it; calibrate() looks for it
/// otherwise.
capture::Session with_chart_place(capture::Session session) {
  auto& chart = session.calibration.colour_chart;
  if (chart && !chart->corners_px) {
    if (const auto place = capture::find_chart_place(session, chart->frames)) {
      chart->corners_px = place->corners_px;
    }
  }
  return session;
}

}  // namespace

void run_calibrate_stage(const capture::Session& session, const capture::HdrOptions& hdr,
                         const fs::path& run, Progress& progress) {
  const calib::CalibrationResult result =
      calib::calibrate(with_chart_place(session), progress, hdr);
  const fs::path partial = run / "calibration.partial";
  fs::remove_all(partial);
  calib::save_calibration(partial, result);
  fs::remove_all(run / "calibration");
  fs::rename(partial, run / "calibration");
}

}  // namespace kappamu::app
