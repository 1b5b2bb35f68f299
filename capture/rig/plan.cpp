#include "capture/rig/plan.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/rig/printables.h"
#include "core/error.h"
#include "core/shown_text.h"
#include "io/atomic_file.h"
#include "io/image/image_file.h"

namespace kappamu::capture {
namespace {

constexpr double shortest_exposure_s = 1.0 / 30.0;
constexpr double seconds_per_frame = 2.0;         // storing, the projector's latency
constexpr double seconds_per_arrangement = 30.0;  // a person moves something
constexpr double patch_overhang = 0.5;

// Extents [mm] of the lit face along its two axes.
std::array<double, 2> lit_face_mm(const Sample& sample) {
  const FaceShape face = face_shape(sample.shape(), sample.lit_face);
  return {face.nu * sample.voxel_mm, face.nv * sample.voxel_mm};
}

ProjectorQuad centred_quad(const PlanRequest& request) {
  const std::array<double, 2> mm = lit_face_mm(request.sample);
  const double half_x = 0.5 * mm[0] * request.projector_px_per_mm;
  const double half_y = 0.5 * mm[1] * request.projector_px_per_mm;
  const double x = 0.5 * (request.projector.width - 1);
  const double y = 0.5 * (request.projector.height - 1);
  if (half_x > x || half_y > y) {
    throw InputError(
        "capture plan: the lit face of " + shown_number(mm[0]) + " x " + shown_number(mm[1]) +
        " mm is " + shown_number(2 * half_x, "%.0f") + " x " + shown_number(2 * half_y, "%.0f") +
        " projector pixels, more than the projector's " + std::to_string(request.projector.width) +
        " x " + std::to_string(request.projector.height) +
        "; move the projector away or take a smaller block.");
  }
  return {{{x - half_x, y - half_y},
           {x + half_x, y - half_y},
           {x + half_x, y + half_y},
           {x - half_x, y + half_y}}};
}

// As large as fits beside a printed board: 40 % of the picture's height.
ProjectedBoard projected_board(const Projector& projector) {
  ProjectedBoard board{7, 5, 0.0, {}};
  board.square_px = std::floor(0.4 * projector.height / (board.rows + 3));
  board.origin_px = {std::floor(0.5 * projector.width) + 2.0 * board.square_px,
                     std::floor(0.5 * (projector.height - board.square_px * (board.rows - 1)))};
  return board;
}

std::string csv(const std::vector<Shot>& shots) {
  std::string text = "file,exposure_s,metered,station,show,subject\n";
  for (const Shot& shot : shots) {
    text += shot.file + "," + shown_number(shot.exposure_s, "%.9g") + "," +
            (shot.metered ? "yes" : "no") + "," + shot.station + "," + shot.show + ",\"" +
            shot.subject + "\"\n";
  }
  return text;
}

nlohmann::ordered_json json(const Plan& plan) {
  nlohmann::ordered_json out{{"format", "kappamu-shots"},     {"version", 1},
                             {"units", {{"time", "s"}}},      {"disk_bytes", plan.disk_bytes},
                             {"exposing_s", plan.exposing_s}, {"working_s", plan.working_s}};
  for (const Shot& shot : plan.shots) {
    out["shots"].push_back({{"file", shot.file},
                            {"exposure_s", shot.exposure_s},
                            {"metered", shot.metered},
                            {"station", shot.station},
                            {"show", shot.show},
                            {"subject", shot.subject}});
  }
  return out;
}

std::string text(const Plan& plan) {
  std::string out =
      "Lens, focus, aperture and sensitivity stay the same throughout; the sample does not move "
      "between its views and the patterns.\nMetered shots: the longest time of the plan that does "
      "not saturate; the others at the stated times, a Gray code's at the time of its white, "
      "phase-shifted light's at the time of its first.\n" +
      std::to_string(plan.shots.size()) + " photographs, " +
      shown_number(plan.disk_bytes / 1e9, "%.2g") + " GB at most, about " +
      shown_number(plan.working_s / 60.0, "%.0f") + " minutes.\n";
  std::string scene;
  for (const Shot& shot : plan.shots) {
    const std::string now =
        shot.subject + "; camera at " + shot.station + "; projector shows " + shot.show;
    if (now != scene) out += "\n" + now + "\n";
    scene = now;
    out += "  [ ] " + shown_number(shot.exposure_s, "%.4g") + " s" +
           (shot.metered ? " (meter)" : "") + "  " + shot.file + "\n";
  }
  return out;
}

}  // namespace

std::vector<double> exposure_times(double period_s, double longest_s, int count) {
  if (!(period_s > 0.0) || count < 1) {
    throw InputError(
        "capture plan: the projector's period must be a positive time and at least one exposure "
        "is needed.");
  }
  // A little tolerance, so that 1/60 s twice is 1/30 s.
  const double first = std::ceil(shortest_exposure_s / period_s - 1e-6);
  const double last = std::floor(longest_s / period_s + 1e-6);
  if (last < first) {
    throw InputError("capture plan: the longest exposure of " + shown_number(longest_s) +
                     " s is below " + shown_number(first * period_s) +
                     " s, the shortest multiple of the projector's period of at least 1/30 s; "
                     "allow longer ones.");
  }
  std::vector<double> times;
  for (int i = 0; i < count; ++i) {
    const double share = count > 1 ? static_cast<double>(i) / (count - 1) : 0.0;
    const double periods = std::round(first * std::pow(last / first, share));
    if (times.empty() || periods * period_s > times.back() * (1.0 + 1e-9)) {
      times.push_back(periods * period_s);
    }
  }
  return times;
}

Plan make_plan(const PlanRequest& request, const std::filesystem::path& folder) {
  const std::array<double, 2> mm = lit_face_mm(request.sample);
  if (!(request.projector_px_per_mm * request.sample.voxel_mm >= 1.0)) {
    throw InputError("capture plan: a voxel of " + shown_number(request.sample.voxel_mm) +
                     " mm is smaller than a projector pixel of " +
                     shown_number(1.0 / request.projector_px_per_mm) +
                     " mm; take a coarser grid or move the projector nearer.");
  }
  Plan plan;
  CapturePlan& capture = plan.capture;
  capture.description = "planned by kappamu plan, lit face " + shown_number(mm[0]) + " x " +
                        shown_number(mm[1]) + " mm";
  capture.setup = request.setup;
  capture.sample = request.sample;
  capture.pattern_station = request.setup == Setup::back_lit ? "back" : "front";
  for (const double time : exposure_times(request.period_s, request.longest_s, request.exposures)) {
    capture.exposures_s.insert(capture.exposures_s.end(), static_cast<std::size_t>(request.repeats),
                               time);
  }
  const ProjectorQuad quad = centred_quad(request);
  capture.patterns = make_fit_patterns(request.projector, quad, request.light, patch_overhang, mm);
  if (request.validate_patches > 0) {
    const auto held_out = make_patch_patterns(request.projector, quad, request.validate_patches,
                                              patch_overhang, PatternRole::validate, "validate_");
    capture.patterns.insert(capture.patterns.end(), held_out.begin(), held_out.end());
  }
  capture.board = request.board;
  capture.camera_board_views = request.boards;
  capture.projector_plane_poses = request.planes;
  capture.projected_board = projected_board(request.projector);
  capture.plane_light = request.plane_light;
  capture.projector_levels = projector_levels(request.projector_levels);
  capture.ambient = request.ambient;
  capture.white_reflectance = request.white_reflectance;
  capture.colour_chart = request.colour_chart;

  static_cast<Rehearsal&>(plan) =
      rehearse_session(request.camera, request.projector, capture, folder);
  std::string scene;
  for (const Shot& shot : plan.shots) {
    plan.exposing_s += shot.exposure_s;
    plan.working_s += shot.exposure_s + seconds_per_frame;
    if (shot.subject + shot.station != scene) plan.working_s += seconds_per_arrangement;
    scene = shot.subject + shot.station;
  }
  const double frame_bytes = 2.0 * 3.0 * request.camera.width * request.camera.height;
  plan.disk_bytes = frame_bytes * static_cast<double>(plan.shots.size());
  return plan;
}

void write_plan(const Plan& plan) {
  const std::filesystem::path& folder = plan.session.folder;
  std::filesystem::create_directories(folder / "patterns");
  std::filesystem::create_directories(folder / "calibration");
  std::filesystem::create_directories(folder / "frames");
  for (const auto& [name, picture] : plan.pictures) {
    if (name.ends_with(".png")) io::write_image(folder / name, picture);
  }
  io::write_text_atomically(folder / "board.pdf", board_pdf(plan.capture.board));
  io::write_text_atomically(folder / "rig.svg",
                            rig_sketch(plan.capture.sample, plan.capture.setup));
  io::write_text_atomically(folder / "shots.csv", csv(plan.shots));
  io::write_text_atomically(folder / "shots.json", json(plan).dump(2) + "\n");
  io::write_text_atomically(folder / "shots.txt", text(plan));
  write_session(plan.session);
}

}  // namespace kappamu::capture
