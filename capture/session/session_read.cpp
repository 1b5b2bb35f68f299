// session.json to Session: form (fields, types, names). What the values mean together is checked in
// session_check.cpp.
#include "capture/session/session.h"
#include "core/error.h"
#include "core/file_name.h"
#include "io/json_node.h"

namespace kappamu::capture {
namespace {

using Node = io::JsonNode;

void expect_unit(const Node& node, const std::string& expected) {
  const std::string value = node.text();
  if (value != expected) {
    node.fail("is '" + shown_name(value) + "'; kappamu sessions are in '" + expected +
              "': convert the numbers and write '" + expected + "'");
  }
}

Frame read_frame(const Node& node) {
  node.expect_fields({"file", "exposure_s"});
  return {node["file"].text(), node["exposure_s"].number()};
}

std::vector<Frame> read_frames(const Node& node) {
  std::vector<Frame> frames;
  for (const Node& item : node.items(1)) frames.push_back(read_frame(item));
  return frames;
}

std::array<double, 2> read_point(const Node& node) {
  const std::vector<Node> xy = node.exactly(2);
  return {xy[0].number(), xy[1].number()};
}

std::array<std::array<double, 2>, 4> read_corners(const Node& node) {
  std::array<std::array<double, 2>, 4> corners{};
  const std::vector<Node> points = node.exactly(4);
  for (std::size_t i = 0; i < 4; ++i) corners[i] = read_point(points[i]);
  return corners;
}

Face read_face(const Node& node) {
  return face_from_string(node.choice({"x-", "x+", "y-", "y+", "z-", "z+"}));
}

Sample read_sample(const Node& node) {
  node.expect_fields({"name", "grid", "voxel_mm", "eta", "sides", "lit_face", "seen_face"});
  Sample sample;
  sample.name = node["name"].text();
  const std::vector<Node> grid = node["grid"].exactly(3);
  for (std::size_t axis = 0; axis < 3; ++axis) sample.grid[axis] = grid[axis].integer();
  sample.voxel_mm = node["voxel_mm"].number();
  sample.eta = node["eta"].number();
  sample.sides = sides_from_string(node["sides"].choice({"open", "mirror"}));
  sample.lit_face = read_face(node["lit_face"]);
  sample.seen_face = read_face(node["seen_face"]);
  return sample;
}

io::RawLayout read_raw_layout(const Node& node) {
  node.expect_fields({"bits", "byte_order", "offset", "mosaic"});
  io::RawLayout layout;
  layout.bits = node["bits"].integer();
  layout.big_endian = node["byte_order"].choice({"little", "big"}) == "big";
  layout.offset = node["offset"].integer();
  const std::string mosaic = node["mosaic"].choice({"RGGB", "BGGR", "GRBG", "GBRG", "none"});
  if (mosaic == "none") return layout;
  layout.mosaic.emplace();
  for (std::size_t site = 0; site < 4; ++site) {
    (*layout.mosaic)[site] = mosaic[site] == 'R' ? 0 : mosaic[site] == 'G' ? 1 : 2;
  }
  return layout;
}

Camera read_camera(const Node& node) {
  node.expect_fields({"width", "height", "bit_depth", "encoding"},
                     {"white_level", "raw_layout", "electrons_full_scale", "read_noise_electrons"});
  Camera camera;
  camera.width = node["width"].integer();
  camera.height = node["height"].integer();
  camera.bit_depth = node["bit_depth"].integer();
  camera.encoding = node["encoding"].choice({"linear", "response"}) == "linear"
                        ? Encoding::linear
                        : Encoding::response;
  if (node.has("white_level")) camera.white_level = node["white_level"].integer();
  if (node.has("raw_layout")) camera.raw_layout = read_raw_layout(node["raw_layout"]);
  if (node.has("electrons_full_scale")) {
    camera.electrons_full_scale = node["electrons_full_scale"].number();
  }
  if (node.has("read_noise_electrons")) {
    camera.read_noise_electrons = node["read_noise_electrons"].number();
  }
  return camera;
}

Pattern read_pattern(const Node& node) {
  node.expect_fields({"id", "image", "role", "frames"});
  Pattern pattern;
  pattern.id = node["id"].text();
  pattern.image = node["image"].text();
  pattern.role =
      node["role"].choice({"fit", "validate"}) == "fit" ? PatternRole::fit : PatternRole::validate;
  pattern.frames = read_frames(node["frames"]);
  return pattern;
}

SampleView read_sample_view(const Node& node) {
  node.expect_fields({"station", "face", "frame"}, {"corners_px"});
  SampleView view;
  view.station = node["station"].text();
  view.face = read_face(node["face"]);
  view.frame = read_frame(node["frame"]);
  if (node.has("corners_px")) view.corners_px = read_corners(node["corners_px"]);
  return view;
}

Board read_board(const Node& node) {
  Board board;
  if (node.has("kind")) {
    const std::string kind =
        node["kind"].choice({"chessboard", "charuco", "circles", "asymmetric-circles"});
    for (const BoardKind known :
         {BoardKind::charuco, BoardKind::circles, BoardKind::asymmetric_circles}) {
      if (kind == to_string(known)) board.kind = known;
    }
  }
  if (board.kind == BoardKind::charuco) {
    node.expect_fields({"columns", "rows", "square_mm", "kind", "marker_mm", "dictionary"});
    board.marker_mm = node["marker_mm"].number();
    board.dictionary = node["dictionary"].text();
  } else {
    node.expect_fields({"columns", "rows", "square_mm"}, {"kind"});
  }
  board.columns = node["columns"].integer();
  board.rows = node["rows"].integer();
  board.square_mm = node["square_mm"].number();
  return board;
}

PhaseShift::Along read_along(const Node& node) {
  return node.choice({"columns", "rows"}) == "columns" ? PhaseShift::Along::columns
                                                       : PhaseShift::Along::rows;
}

Calibration read_calibration(const Node& node) {
  node.expect_fields({"board", "camera_boards", "projector_planes", "sample_views", "dark"},
                     {"projected_board", "white_target", "colour_chart", "ambient"});
  Calibration calibration;
  calibration.board = read_board(node["board"]);
  calibration.camera_boards = read_frames(node["camera_boards"]);
  if (node.has("projected_board")) {
    const Node projected = node["projected_board"];
    projected.expect_fields({"columns", "rows", "square_px", "origin_px"});
    calibration.projected_board =
        ProjectedBoard{projected["columns"].integer(), projected["rows"].integer(),
                       projected["square_px"].number(), read_point(projected["origin_px"])};
  }
  for (const Node& plane : node["projector_planes"].items(1)) {
    plane.expect_fields({"board"}, {"projected", "gray_code", "phase_shift", "correspondences"});
    ProjectorPlane read{read_frame(plane["board"]), {}};
    if (plane.has("projected")) read.projected = read_frame(plane["projected"]);
    if (plane.has("gray_code")) read.gray_code = read_frames(plane["gray_code"]);
    if (plane.has("phase_shift")) {
      for (const Node& set : plane["phase_shift"].items(1)) {
        set.expect_fields({"along", "period_px", "frames"});
        read.phase_shift.push_back(
            {read_along(set["along"]), set["period_px"].number(), read_frames(set["frames"])});
      }
    }
    if (plane.has("correspondences")) read.correspondences = plane["correspondences"].text();
    calibration.projector_planes.push_back(std::move(read));
  }
  for (const Node& view : node["sample_views"].items(1)) {
    calibration.sample_views.push_back(read_sample_view(view));
  }
  calibration.dark = read_frames(node["dark"]);
  if (node.has("white_target")) {
    const Node white = node["white_target"];
    white.expect_fields({"reflectance", "frames"}, {"black_frames", "off_frames", "levels"});
    calibration.white_target =
        WhiteTarget{white["reflectance"].number(), read_frames(white["frames"])};
    if (white.has("black_frames")) {
      calibration.white_target_black = read_frames(white["black_frames"]);
    }
    if (white.has("off_frames")) {
      calibration.white_target->off_frames = read_frames(white["off_frames"]);
    }
    if (white.has("levels")) {
      for (const Node& level : white["levels"].items(1)) {
        level.expect_fields({"value", "frames"});
        calibration.white_target->levels.push_back(
            {level["value"].integer(), read_frames(level["frames"])});
      }
    }
  }
  if (node.has("ambient")) {
    for (const Node& time : node["ambient"].items(1)) {
      time.expect_fields({"frames"});
      calibration.ambient.push_back(read_frames(time["frames"]));
    }
  }
  if (node.has("colour_chart")) {
    const Node chart = node["colour_chart"];
    chart.expect_fields({"frames"}, {"corners_px"});
    calibration.colour_chart = ColourChart{read_frames(chart["frames"]), std::nullopt};
    if (chart.has("corners_px")) {
      calibration.colour_chart->corners_px = read_corners(chart["corners_px"]);
    }
  }
  return calibration;
}

Session read_document(const Node& node) {
  // Format and version first: a file of another kind should not be blamed for its fields.
  node.expect_fields({"format", "version", "units", "setup", "channels", "sample", "camera",
                      "projector", "stations", "patterns", "calibration"},
                     {"description"});
  node.expect_format("kappamu-session");
  const Node units = node["units"];
  units.expect_fields({"length", "time"});
  expect_unit(units["length"], "mm");
  expect_unit(units["time"], "s");

  Session session;
  if (node.has("description")) session.description = node["description"].text();
  session.setup = node["setup"].choice({"back-lit", "front-lit"}) == "back-lit" ? Setup::back_lit
                                                                                : Setup::front_lit;
  session.channels.clear();
  for (const Node& channel : node["channels"].items(1)) session.channels.push_back(channel.text());
  session.sample = read_sample(node["sample"]);
  session.camera = read_camera(node["camera"]);
  const Node projector = node["projector"];
  projector.expect_fields({"width", "height"});
  session.projector = {projector["width"].integer(), projector["height"].integer()};
  const Node stations = node["stations"];
  stations.expect_fields({"calibration", "patterns"});
  session.calibration_station = stations["calibration"].text();
  session.pattern_station = stations["patterns"].text();
  for (const Node& pattern : node["patterns"].items(1)) {
    session.patterns.push_back(read_pattern(pattern));
  }
  session.calibration = read_calibration(node["calibration"]);
  return session;
}

}  // namespace

Session read_session(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "session.json";
  const std::string file = path.string();
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored)) {
    throw InputError(folder.string() +
                     ": no such folder; give the folder that holds session.json.");
  }
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw InputError(file + ": no such file; a capture session is a folder with a session.json.");
  }
  Session session = read_document(io::JsonDocument(path, "docs/formats.md").root());
  session.folder = folder;
  validate(session);
  return session;
}

}  // namespace kappamu::capture
