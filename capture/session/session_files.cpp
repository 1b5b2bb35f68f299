#include "capture/session/session_files.h"

#include <system_error>

#include "core/error.h"

namespace kappamu::capture {

namespace fs = std::filesystem;

std::vector<std::string> named_files(const Session& session) {
  std::vector<std::string> files;
  const auto add = [&](const Stack& stack) {
    for (const Frame& frame : stack) files.push_back(frame.file);
  };
  for (const Pattern& pattern : session.patterns) {
    files.push_back(pattern.image);
    add(pattern.frames);
  }
  const Calibration& calibration = session.calibration;
  if (calibration.lens) files.push_back(calibration.lens->file);
  add(calibration.camera_boards);
  for (const ProjectorPlane& plane : calibration.projector_planes) {
    files.push_back(plane.board.file);
    if (plane.projected) files.push_back(plane.projected->file);
    add(plane.gray_code);
    for (const PhaseShift& set : plane.phase_shift) add(set.frames);
    if (!plane.correspondences.empty()) files.push_back(plane.correspondences);
  }
  for (const SampleView& view : calibration.sample_views) files.push_back(view.frame.file);
  add(calibration.dark);
  if (calibration.white_target) {
    add(calibration.white_target->frames);
    add(calibration.white_target->black_frames);
    add(calibration.white_target->off_frames);
    for (const ProjectorLevel& level : calibration.white_target->levels) add(level.frames);
  }
  for (const Stack& stack : calibration.ambient) add(stack);
  if (calibration.colour_chart) add(calibration.colour_chart->frames);
  return files;
}

bool leads_inside(const fs::path& folder, const fs::path& file) {
  std::error_code error;
  const fs::path target = fs::weakly_canonical(folder / file, error);
  // A link round in a circle leads to nothing that could be read.
  if (error == std::errc::too_many_symbolic_link_levels) return true;
  if (error) return false;
  const fs::path inside = target.lexically_relative(fs::weakly_canonical(folder, error));
  return !error && !inside.empty() && *inside.begin() != "..";
}

void require_inside(const fs::path& folder, const fs::path& file) {
  if (leads_inside(folder, file)) return;
  throw InputError((folder / file).string() + ": is or lies behind a link out of " +
                       folder.string() +
                       "; copy the file into it, or follow links and read it where it is",
                   {{"follow_links"}});
}

void require_files_inside(const Session& session) {
  for (const std::string& file : named_files(session)) require_inside(session.folder, file);
}

}  // namespace kappamu::capture
