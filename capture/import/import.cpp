#include "capture/import/import.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <regex>

#include "capture/import/code_depth.h"
#include "capture/import/import_photographs.h"
#include "capture/radiance/merge.h"
#include "capture/response/radiometry.h"
#include "capture/session/frames.h"
#include "capture/session/session_files.h"
#include "core/error.h"
#include "core/shown_text.h"
#include "io/atomic_file.h"
#include "io/read_file.h"

namespace kappamu::capture {
namespace {

namespace fs = std::filesystem;

// One name for plane_07_gray_3, plane_7_gray_03 and plane_7_gray_3.
std::string without_leading_zeros(const std::string& shot) {
  static const std::regex numbered("(plane|level|ambient)_[0-9]+.*");
  static const std::regex zeros("_0+([0-9])");
  return std::regex_match(shot, numbered) ? std::regex_replace(shot, zeros, "_$1") : shot;
}

// Nothing that is there already is replaced.
void copy_into(const fs::path& folder, const std::string& file, const fs::path& source) {
  const fs::path target = folder / file;
  std::error_code error;
  if (fs::symlink_status(target, error).type() != fs::file_type::not_found) {
    if (same_content(source, target)) return;
    throw InputError(target.string() + ": is there already and another file than " +
                         source.string() + "; move it elsewhere or choose another session folder",
                     {{"out"}});
  }
  if (!leads_inside(folder, file)) {
    throw InputError(
        target.string() +
            ": lies behind a link out of the session folder; remove the link or choose "
            "another session folder",
        {{"out"}});
  }
  io::write_bytes_atomically(target, io::read_bytes(source));
}

// Photographs by shot, taken out as their place in the session is found.
class Shots {
 public:
  Shots(std::vector<Photograph> photographs, const ImportOptions& options)
      : options_(options), session_folder_(fs::weakly_canonical(options.out)) {
    for (Photograph& photograph : photographs) {
      by_shot_[without_leading_zeros(photograph.shot)].push_back(std::move(photograph));
    }
  }

  /// Frames of a shot by rising exposure time; empty if there are none.
  std::vector<Frame> take(const std::string& shot) {
    std::vector<Frame> frames;
    const auto found = by_shot_.find(without_leading_zeros(shot));
    if (found == by_shot_.end()) return frames;
    for (const Photograph& photograph : found->second) {
      frames.push_back({place(photograph), photograph.exposure_s});
    }
    by_shot_.erase(found);
    return frames;
  }
  std::vector<Frame> need(const std::string& shot, const std::string& what) {
    std::vector<Frame> frames = take(shot);
    if (frames.empty()) fail_without(shot, what, shot + "_0");
    return frames;
  }
  /// The one photograph of a shot that is no stack.
  Frame need_one(const std::string& shot, const std::string& what) {
    const std::vector<Frame> frames = take(shot);
    if (frames.empty()) fail_without(shot, what, shot);
    if (frames.size() > 1) {
      throw InputError((options_.out / frames[1].file).string() + ": a second photograph of " +
                       what + "; keep one.");
    }
    return frames.front();
  }
  bool has(const std::string& shot) const {
    return by_shot_.count(without_leading_zeros(shot)) > 0;
  }

  void check_all_taken() const {
    if (by_shot_.empty()) return;
    const Photograph& odd = by_shot_.begin()->second.front();
    throw InputError(odd.path.string() + ": '" + odd.shot +
                     "' is no shot of the plan (a pattern's id, board, plane_<n>_board, "
                     "plane_<n>_projected, plane_<n>_gray_<k>, plane_<n>_phase_<k>, "
                     "sample_<station>, dark, white, "
                     "black, level_<value>, off, ambient_<n>, chart); rename the photograph, take "
                     "it out, or list the right ones in a table.");
  }

  /// Copies what does not lie in the session's folder yet.
  void copy() const {
    for (const auto& [to, from] : copies_) copy_into(session_folder_, to, from);
  }

 private:
  [[noreturn]] void fail_without(const std::string& shot, const std::string& what,
                                 const std::string& file) const {
    throw InputError(options_.photographs.string() + ": there is no photograph of " + what +
                     "; name it " + file + " (any image ending), or list it as shot '" + shot +
                     "' in a table.");
  }
  // The name in the session: where it is already, or photographs/ and its place in the folder.
  std::string place(const Photograph& photograph) {
    const fs::path path = fs::weakly_canonical(photograph.path);
    const fs::path inside = path.lexically_relative(session_folder_);
    if (!inside.empty() && *inside.begin() != "..") return inside.generic_string();
    std::string name =
        "photographs/" + photograph.path.lexically_relative(options_.photographs).generic_string();
    copies_.emplace_back(name, path);
    return name;
  }

  const ImportOptions& options_;
  fs::path session_folder_;
  std::map<std::string, std::vector<Photograph>> by_shot_;
  std::vector<std::pair<std::string, fs::path>> copies_;
};

// The frames of a plane's Gray code, which the numbers in their names put in order; none where the
// plane has no such photograph.
std::vector<Frame> find_gray_code(const std::string& plane, const Projector& projector,
                                  Shots& shots) {
  const int needed = gray_code_frames(projector);
  std::vector<std::string> names;
  for (int k = 0; k < needed; ++k) names.push_back(plane + "_gray_" + std::to_string(k));
  std::vector<Frame> code;
  if (std::none_of(names.begin(), names.end(), [&](const auto& name) { return shots.has(name); })) {
    return code;
  }
  for (const std::string& name : names) {
    code.push_back(shots.need_one(name, "frame " + name +
                                            " of the Gray code (the projector's has " +
                                            std::to_string(needed) + ", from 0)"));
  }
  return code;
}

// The frames of a plane's phase shifts as the plan's first plane has them, numbered through.
std::vector<PhaseShift> find_phase_shift(const std::string& plane, std::vector<PhaseShift> sets,
                                         Shots& shots) {
  if (sets.empty() || !shots.has(plane + "_phase_0")) return {};
  int k = 0;
  for (PhaseShift& set : sets) {
    for (Frame& frame : set.frames) {
      const std::string name = plane + "_phase_" + std::to_string(k++);
      frame = shots.need_one(name, "frame " + name + " of the phase-shifted light");
    }
  }
  return sets;
}

void find_planes(const Session& plan, Shots& shots, Session& session) {
  Calibration& calibration = session.calibration;
  std::vector<ProjectorPlane>& planes = calibration.projector_planes;
  const std::vector<ProjectorPlane>& planned = plan.calibration.projector_planes;
  planes.clear();
  // As many as there are, planned or not, numbered with gaps or without.
  const int last =
      std::max<int>(100, 2 * static_cast<int>(plan.calibration.projector_planes.size()));
  for (int i = 0; i < last; ++i) {
    const std::string name = "plane_" + std::to_string(i);
    ProjectorPlane plane;
    plane.gray_code = find_gray_code(name, session.projector, shots);
    if (!planned.empty()) {
      plane.phase_shift = find_phase_shift(name, planned.front().phase_shift, shots);
    }
    if (!plane.coded() && !shots.has(name + "_board") && !shots.has(name + "_projected")) continue;
    plane.board = shots.need_one(name + "_board", "the printed board of " + name);
    if (!plane.coded() || shots.has(name + "_projected")) {
      plane.projected = shots.need_one(name + "_projected", "the projected board of " + name);
    }
    planes.push_back(std::move(plane));
  }
  if (planes.empty()) {
    shots.need_one("plane_0_board", "the printed board on a projector plane");
  }
  const bool boards = std::any_of(planes.begin(), planes.end(), [](const ProjectorPlane& plane) {
    return plane.projected.has_value();
  });
  if (!boards) calibration.projected_board.reset();
}

void find_targets(Shots& shots, Session& session, Progress& progress) {
  Calibration& calibration = session.calibration;
  if (std::optional<WhiteTarget>& target = calibration.white_target) {
    target->frames = shots.take("white");
    if (target->frames.empty()) {
      target.reset();
      progress.warn("there are no photographs of the white target (white_0 ...).");
    } else {
      target->black_frames = shots.take("black");
      target->off_frames = shots.take("off");
      target->levels.clear();
      for (int value = 1; value < 255; ++value) {
        Stack frames = shots.take("level_" + std::to_string(value));
        if (!frames.empty()) target->levels.push_back({value, std::move(frames)});
      }
    }
  }
  calibration.ambient.clear();
  for (int time = 0; time < 100; ++time) {
    Stack frames = shots.take("ambient_" + std::to_string(time));
    if (!frames.empty()) calibration.ambient.push_back(std::move(frames));
  }
  if (calibration.colour_chart) {
    calibration.colour_chart->frames = shots.take("chart");
    calibration.colour_chart->corners_px.reset();
    if (calibration.colour_chart->frames.empty()) {
      calibration.colour_chart.reset();
      progress.warn("there are no photographs of the colour chart (chart_0 ...).");
    }
  }
}

bool has_exposure(const Stack& stack, double exposure_s) {
  constexpr double equal_times = 0.02;  // cameras round what they write
  return std::any_of(stack.begin(), stack.end(), [&](const Frame& frame) {
    return std::abs(frame.exposure_s - exposure_s) <= equal_times * exposure_s;
  });
}

// A stack without an exposure that most have is merged all the same, with more noise or saturated
// pixels, and nothing later shows why.
void warn_of_missing_exposures(const std::vector<Pattern>& patterns, Progress& progress) {
  Stack looked_at;
  for (const Pattern& pattern : patterns) {
    for (const Frame& frame : pattern.frames) {
      if (has_exposure(looked_at, frame.exposure_s)) continue;
      looked_at.push_back(frame);
      std::string first;
      std::size_t lacking = 0;
      for (const Pattern& other : patterns) {
        if (has_exposure(other.frames, frame.exposure_s)) continue;
        if (lacking++ == 0) first = other.id;
      }
      if (lacking == 0 || 2 * lacking >= patterns.size()) continue;
      progress.warn("pattern " + first + " has no photograph of " +
                    shown_number(frame.exposure_s, "%.4g s") + ", which most patterns have" +
                    (lacking == 1 ? "" : ", nor have " + std::to_string(lacking - 1) + " others") +
                    ": add it, or expect more noise there.");
    }
  }
}

// A longer exposure of a stack shows less or more than its time says: mislabelled, or the shutter
// did not do what it was asked.
void check_brightness(const Session& session, Progress& progress) {
  const Radiometry radiometry = find_radiometry(session, progress);
  const auto check = [&](const Stack& stack, const std::string& label) {
    for (const Fault& fault : find_stack_faults(session, stack, radiometry)) {
      if (fault.kind == Fault::Kind::blank) {
        throw InputError((session.folder / stack[fault.frame].file).string() + ": " +
                         fault.sentence + " (" + label +
                         "); photograph it again, or take it out of the photographs' folder and "
                         "the table.");
      }
      if (fault.kind != Fault::Kind::mislabelled) continue;
      throw InputError((session.folder / stack[fault.frame].file).string() + ": " + fault.sentence +
                           " (" + label +
                           "); correct its exposure time with a table, or photograph the stack "
                           "again",
                       {{"table"}});
    }
  };
  const Calibration& calibration = session.calibration;
  if (calibration.white_target) {
    check(calibration.white_target->frames, "white target");
    for (const ProjectorLevel& level : calibration.white_target->levels) {
      check(level.frames, "white target under " + std::to_string(level.value));
    }
  }
  if (calibration.colour_chart) check(calibration.colour_chart->frames, "colour chart");
  for (std::size_t i = 0; i < session.patterns.size(); ++i) {
    const Pattern& pattern = session.patterns[i];
    progress.update("import", 0.4 + 0.6 * static_cast<double>(i) / session.patterns.size(),
                    pattern.id);
    check(pattern.frames, "pattern " + pattern.id);
  }
}

}  // namespace

Session import_session(const ImportOptions& options, Progress& progress) {
  const Session plan = read_session(options.plan);
  if (fs::exists(options.out / "session.json")) {
    throw InputError((options.out / "session.json").string() +
                         ": is there already; move it elsewhere or choose another session folder",
                     {{"out"}});
  }
  std::vector<Photograph> photographs =
      find_photographs({options.photographs, options.table, options.links, options.plan}, progress);
  require_exposure_times(photographs);
  check_settings(photographs);
  Session session = plan;
  session.folder = options.out;
  session.source.clear();  // the camera is the photographs', not the plan's
  if (read_camera(photographs.front().path, session.camera) == 1 && session.channels.size() > 1) {
    session.channels = {"Y"};
    progress.warn("the photographs are grey: the session has one channel, Y.");
  }
  settle_depth(photographs, options.plan, session.camera, progress);
  settle_orientation(photographs, options.orientation, session.camera, progress);

  Shots shots(std::move(photographs), options);
  for (Pattern& pattern : session.patterns) {
    pattern.frames = shots.need(pattern.id, "pattern " + pattern.id);
  }
  warn_of_missing_exposures(session.patterns, progress);
  Calibration& calibration = session.calibration;
  calibration.camera_boards = shots.need("board", "the printed board");
  find_planes(plan, shots, session);
  for (SampleView& view : calibration.sample_views) {
    view.frame =
        shots.need_one("sample_" + view.station, "the sample from station " + view.station);
    view.corners_px.reset();  // of other pictures
  }
  calibration.dark = shots.need("dark", "the covered lens");
  find_targets(shots, session, progress);
  shots.check_all_taken();
  validate(session);

  shots.copy();
  for (const Pattern& pattern : session.patterns) {
    const fs::path source = options.plan / pattern.image;
    std::error_code error;
    if (!fs::is_regular_file(source, error)) {
      throw InputError(source.string() + ": no such image of pattern " + pattern.id +
                       "; session.json there lists it.");
    }
    if (options.links == Links::within) require_inside(options.plan, pattern.image);
    load_pattern(plan, pattern);
    copy_into(options.out, pattern.image, source);
  }
  if (const auto& lens = calibration.lens) {
    const fs::path source = options.plan / lens->file;
    std::error_code error;
    if (!fs::is_regular_file(source, error)) {
      throw InputError(source.string() + ": no such file; calibration.lens.file of " +
                       shown_session(session) + " names it.");
    }
    if (options.links == Links::within) require_inside(options.plan, lens->file);
    copy_into(options.out, lens->file, source);
  }
  check_brightness(session, progress);
  write_session(session);
  progress.update("import", 1.0, "done");
  return session;
}

}  // namespace kappamu::capture
