// Session to session.json, in the field order of docs/formats.md.
#include <bit>
#include <nlohmann/json.hpp>

#include "capture/session/session.h"
#include "core/error.h"
#include "io/atomic_file.h"
#include "io/json_reason.h"

namespace kappamu::capture {
namespace {

using json = nlohmann::ordered_json;

json to_json(const Frame& frame) {
  return {{"file", frame.file}, {"exposure_s", frame.exposure_s}};
}

json to_json(const std::vector<Frame>& frames) {
  json list = json::array();
  for (const Frame& frame : frames) list.push_back(to_json(frame));
  return list;
}

json to_json(const io::RawLayout& layout) {
  std::string mosaic;
  if (layout.mosaic) {
    for (const int colour : *layout.mosaic) mosaic += "RGB"[colour];
  }
  return {{"bits", layout.bits},
          {"byte_order", layout.big_endian ? "big" : "little"},
          {"offset", layout.offset},
          {"mosaic", mosaic.empty() ? "none" : mosaic}};
}

json to_json(const Camera& camera) {
  json out{{"width", camera.width},
           {"height", camera.height},
           {"bit_depth", camera.bit_depth},
           {"encoding", camera.encoding == Encoding::linear ? "linear" : "response"}};
  if (camera.white_level) out["white_level"] = *camera.white_level;
  if (camera.raw_layout) out["raw_layout"] = to_json(*camera.raw_layout);
  if (camera.electrons_full_scale) out["electrons_full_scale"] = *camera.electrons_full_scale;
  if (camera.read_noise_electrons) out["read_noise_electrons"] = *camera.read_noise_electrons;
  return out;
}

json to_json(const Sample& sample) {
  return {{"name", sample.name},
          {"grid", sample.grid},
          {"voxel_mm", sample.voxel_mm},
          {"eta", sample.eta},
          {"sides", to_string(sample.sides)},
          {"lit_face", to_string(sample.lit_face)},
          {"seen_face", to_string(sample.seen_face)}};
}

json to_json(const Pattern& pattern) {
  return {{"id", pattern.id},
          {"image", pattern.image},
          {"role", pattern.role == PatternRole::fit ? "fit" : "validate"},
          {"frames", to_json(pattern.frames)}};
}

json to_json(const SampleView& view) {
  json out{
      {"station", view.station}, {"face", to_string(view.face)}, {"frame", to_json(view.frame)}};
  if (view.corners_px) out["corners_px"] = *view.corners_px;
  return out;
}

json to_json(const Board& board) {
  json out{{"columns", board.columns}, {"rows", board.rows}, {"square_mm", board.square_mm}};
  if (board.kind != BoardKind::chessboard) out["kind"] = to_string(board.kind);
  if (board.kind == BoardKind::charuco) {
    out["marker_mm"] = board.marker_mm;
    out["dictionary"] = board.dictionary;
  }
  return out;
}

json to_json(const Calibration& calibration) {
  json planes = json::array();
  for (const ProjectorPlane& plane : calibration.projector_planes) {
    planes.push_back({{"board", to_json(plane.board)}});
    if (plane.projected) planes.back()["projected"] = to_json(*plane.projected);
    if (!plane.gray_code.empty()) planes.back()["gray_code"] = to_json(plane.gray_code);
    for (const PhaseShift& set : plane.phase_shift) {
      planes.back()["phase_shift"].push_back(
          {{"along", set.along == PhaseShift::Along::columns ? "columns" : "rows"},
           {"period_px", set.period_px},
           {"frames", to_json(set.frames)}});
    }
    if (!plane.correspondences.empty()) planes.back()["correspondences"] = plane.correspondences;
  }
  json views = json::array();
  for (const SampleView& view : calibration.sample_views) views.push_back(to_json(view));
  json out{{"board", to_json(calibration.board)},
           {"camera_boards", to_json(calibration.camera_boards)}};
  if (const auto& projected = calibration.projected_board) {
    out["projected_board"] = {{"columns", projected->columns},
                              {"rows", projected->rows},
                              {"square_px", projected->square_px},
                              {"origin_px", projected->origin_px}};
  }
  out["projector_planes"] = std::move(planes);
  out["sample_views"] = std::move(views);
  out["dark"] = to_json(calibration.dark);
  if (calibration.white_target) {
    json& white = out["white_target"];
    white["reflectance"] = calibration.white_target->reflectance;
    white["frames"] = to_json(calibration.white_target->frames);
    if (!calibration.white_target_black.empty()) {
      white["black_frames"] = to_json(calibration.white_target_black);
    }
    if (!calibration.white_target->off_frames.empty()) {
      white["off_frames"] = to_json(calibration.white_target->off_frames);
    }
    for (const ProjectorLevel& level : calibration.white_target->levels) {
      white["levels"].push_back({{"value", level.value}, {"frames", to_json(level.frames)}});
    }
  }
  if (calibration.colour_chart) {
    json& chart = out["colour_chart"];
    chart["frames"] = to_json(calibration.colour_chart->frames);
    if (calibration.colour_chart->corners_px) {
      chart["corners_px"] = *calibration.colour_chart->corners_px;
    }
  }
  for (const Stack& frames : calibration.ambient) {
    out["ambient"].push_back({{"frames", to_json(frames)}});
  }
  return out;
}

}  // namespace

std::string to_string(BoardKind kind) {
  switch (kind) {
    case BoardKind::chessboard:
      return "chessboard";
    case BoardKind::charuco:
      return "charuco";
    case BoardKind::circles:
      return "circles";
    case BoardKind::asymmetric_circles:
      return "asymmetric-circles";
  }
  throw InternalError("internal error: unknown kind of board");
}

int gray_code_frames(const Projector& projector) {
  const auto bits = [](int extent) {
    return static_cast<int>(std::bit_width(static_cast<unsigned>(extent - 1)));
  };
  return 2 * (bits(projector.width) + bits(projector.height)) + 2;
}

void write_session(const Session& session) {
  validate(session);
  json patterns = json::array();
  for (const Pattern& pattern : session.patterns) patterns.push_back(to_json(pattern));
  json document{
      {"format", "kappamu-session"},
      {"version", 1},
      {"units", {{"length", "mm"}, {"time", "s"}}},
      {"setup", session.setup == Setup::back_lit ? "back-lit" : "front-lit"},
      {"channels", session.channels},
      {"sample", to_json(session.sample)},
      {"camera", to_json(session.camera)},
      {"projector", {{"width", session.projector.width}, {"height", session.projector.height}}},
      {"stations",
       {{"calibration", session.calibration_station}, {"patterns", session.pattern_station}}},
      {"patterns", std::move(patterns)},
      {"calibration", to_json(session.calibration)}};
  if (!session.description.empty()) document["description"] = session.description;
  std::string text;
  try {
    text = document.dump(2) + "\n";
  } catch (const json::exception& error) {
    throw InputError((session.folder / "session.json").string() +
                     ": a name is not valid UTF-8; rename it (" + io::json_reason(error) + ").");
  }
  io::write_text_atomically(session.folder / "session.json", text);
}

}  // namespace kappamu::capture
