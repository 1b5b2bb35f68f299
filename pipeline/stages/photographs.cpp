#include "pipeline/stages/photographs.h"

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "calib/calibration_file.h"
#include "capture/response/radiometry.h"
#include "pipeline/stages/hdr_file.h"

namespace kappamu::pipeline {

namespace {

BracketSummary summary_of(const capture::Session& session, const capture::HdrImage& image) {
  BracketSummary summary{session.patterns.front().frames.size(), session.calibration.dark.size()};
  double darkest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < image.flags.size(); ++i) {
    const std::uint8_t flag = image.flags.values()[i];
    if ((flag & capture::pixel_saturated) != 0) ++summary.saturated_share;
    if ((flag & capture::pixel_dark) != 0) ++summary.dark_share;
    if (flag != capture::pixel_ok) continue;
    const double radiance = image.radiance.values()[i];
    darkest = std::min(darkest, radiance);
    summary.brightest = std::max(summary.brightest, radiance);
  }
  summary.darkest = std::min(darkest, summary.brightest);
  summary.saturated_share /= static_cast<double>(image.flags.size());
  summary.dark_share /= static_cast<double>(image.flags.size());
  return summary;
}

}  // namespace

BracketSummary merge_photographs(const capture::PhotographSource& source,
                                 capture::Encoding encoding, const capture::MergeOptions& hdr,
                                 const std::filesystem::path& output, Progress& progress) {
  const capture::Session session = capture::bracket_session(source, encoding, progress);
  const capture::Radiometry radiometry = capture::find_radiometry(session, progress);
  std::vector<std::string> notes;
  const capture::HdrImage image = capture::merge_stack(session, session.patterns.front().frames,
                                                       "bracket", radiometry, hdr, &notes);
  for (const std::string& note : notes) progress.warn(note);
  write_hdr(output / "radiance.exr", image, session, notes);
  calib::save_response(output, radiometry);
  progress.update("merge", 1.0, "done");
  return summary_of(session, image);
}

calib::CalibrationResult calibrate_photographs(const capture::PhotographSource& source,
                                               const capture::Board& board,
                                               const std::optional<capture::Projector>& projector,
                                               const std::optional<calib::KnownLens>& known,
                                               const std::filesystem::path& output,
                                               Progress& progress) {
  const calib::CalibrationResult result = calib::calibrate_lenses_alone(
      capture::board_session(source, board, projector, progress), progress, known);
  calib::save_lenses(output, result);
  return result;
}

}  // namespace kappamu::pipeline
