// session.json to Session: form (fields, types, names). What the values mean together is checked in
// session_check.cpp.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "capture/session/session.h"
#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"
#include "io/json_reason.h"
#include "io/read_file.h"

namespace kappamu::capture {
namespace {

using nlohmann::json;

// A JSON value that knows where it stands, so that every message can name its path.
class Node {
 public:
  Node(const json& value, std::string path, const std::string& file)
      : value_(&value), path_(std::move(path)), file_(&file) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(*file_ + ": " + (path_.empty() ? "the document" : path_) + " " + what + ".");
  }

  // Refuses anything but an object with exactly these fields; those in `optional` may be missing.
  void expect_fields(std::initializer_list<std::string_view> required,
                     std::initializer_list<std::string_view> optional = {}) const {
    if (!value_->is_object()) fail("is " + kind() + "; write an object in braces");
    for (const auto& [name, unused] : value_->items()) {
      if (!contains(required, name) && !contains(optional, name)) {
        Node(*value_, child_path(name), *file_)
            .fail("is an unknown field; allowed here are " + list(required, optional));
      }
    }
    for (const std::string_view name : required) {
      if (!value_->contains(name)) {
        Node(*value_, child_path(name), *file_).fail("is missing; add it (docs/formats.md)");
      }
    }
  }

  bool has(std::string_view name) const { return value_->contains(name); }
  Node operator[](const char* name) const { return {value_->at(name), child_path(name), *file_}; }

  std::vector<Node> items(std::size_t at_least) const {
    if (!value_->is_array()) fail("is " + kind() + "; write a list in brackets");
    if (value_->size() < at_least) {
      fail("has " + std::to_string(value_->size()) + " entries; it needs at least " +
           std::to_string(at_least));
    }
    std::vector<Node> nodes;
    nodes.reserve(value_->size());
    for (std::size_t i = 0; i < value_->size(); ++i) {
      nodes.emplace_back((*value_)[i], path_ + "[" + std::to_string(i) + "]", *file_);
    }
    return nodes;
  }
  std::vector<Node> exactly(std::size_t count) const {
    std::vector<Node> nodes = items(0);
    if (nodes.size() != count) {
      fail("has " + std::to_string(nodes.size()) + " entries; it needs exactly " +
           std::to_string(count));
    }
    return nodes;
  }

  std::string text() const {
    if (!value_->is_string()) fail("is " + kind() + "; write a text in quotes");
    return value_->get<std::string>();
  }
  double number() const {
    if (!value_->is_number()) fail("is " + kind() + "; write a number");
    return value_->get<double>();
  }
  int integer() const {
    const double value = number();
    if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max()) {
      fail("is " + value_->dump() + "; write a whole number");
    }
    return static_cast<int>(value);
  }
  // A text out of a fixed list.
  std::string choice(std::initializer_list<std::string_view> choices) const {
    std::string value = text();
    if (!contains(choices, value))
      fail("is '" + shown_name(value) + "'; write " + list(choices, {}, " or "));
    return value;
  }
  void unit(const std::string& expected) const {
    const std::string value = text();
    if (value != expected) {
      fail("is '" + shown_name(value) + "'; kappamu sessions are in '" + expected +
           "': convert the numbers and write '" + expected + "'");
    }
  }

 private:
  static bool contains(std::initializer_list<std::string_view> names, std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  }
  static std::string list(std::initializer_list<std::string_view> first,
                          std::initializer_list<std::string_view> second,
                          const std::string& separator = ", ") {
    std::string text;
    for (const auto& names : {first, second}) {
      for (const std::string_view name : names) {
        text += (text.empty() ? "'" : separator + "'") + std::string(name) + "'";
      }
    }
    return text;
  }
  std::string child_path(std::string_view name) const {
    return path_.empty() ? std::string(name) : path_ + "." + std::string(name);
  }
  std::string kind() const {
    if (value_->is_object()) return "an object";
    if (value_->is_array()) return "a list";
    if (value_->is_string()) return "a text";
    return value_->dump();
  }

  const json* value_;
  std::string path_;
  const std::string* file_;
};

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

Camera read_camera(const Node& node) {
  node.expect_fields({"width", "height", "bit_depth", "encoding"},
                     {"white_level", "electrons_full_scale", "read_noise_electrons"});
  Camera camera;
  camera.width = node["width"].integer();
  camera.height = node["height"].integer();
  camera.bit_depth = node["bit_depth"].integer();
  camera.encoding = node["encoding"].choice({"linear", "response"}) == "linear"
                        ? Encoding::linear
                        : Encoding::response;
  if (node.has("white_level")) camera.white_level = node["white_level"].integer();
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
    plane.expect_fields({"board"}, {"projected", "gray_code"});
    ProjectorPlane read{read_frame(plane["board"]), {}};
    if (plane.has("projected")) read.projected = read_frame(plane["projected"]);
    if (plane.has("gray_code")) read.gray_code = read_frames(plane["gray_code"]);
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
  node["format"].choice({"kappamu-session"});
  if (node["version"].number() != 1.0) {
    node["version"].fail("is not 1; this program reads version 1");
  }
  const Node units = node["units"];
  units.expect_fields({"length", "time"});
  units["length"].unit("mm");
  units["time"].unit("s");

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

// nlohmann::json keeps the last of two equal keys; a doubled field is a mistake worth telling.
json parse(const std::string& text, const std::string& file) {
  std::vector<std::set<std::string>> open_objects;
  const auto watch = [&](int /*depth*/, json::parse_event_t event, json& parsed) {
    if (event == json::parse_event_t::object_start) open_objects.emplace_back();
    if (event == json::parse_event_t::object_end) open_objects.pop_back();
    if (event == json::parse_event_t::key &&
        !open_objects.back().insert(parsed.get<std::string>()).second) {
      throw InputError(file + ": field '" + shown_name(parsed.get<std::string>()) +
                       "' occurs twice in one object; remove one of the two.");
    }
    return true;
  };
  try {
    return json::parse(text, watch);
  } catch (const json::exception& error) {
    throw InputError(file + ": not valid JSON (" + shown_text(io::json_reason(error)) +
                     "); correct it there.");
  }
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
  const json document = parse(io::read_text(path), file);
  Session session;
  try {
    session = read_document(Node(document, "", file));
  } catch (const json::exception& error) {
    // Strings that are not UTF-8 surface only when a message quotes them.
    throw InputError(file + ": not valid JSON text (" + io::json_reason(error) +
                     "); save it as UTF-8.");
  }
  session.folder = folder;
  validate(session);
  return session;
}

}  // namespace kappamu::capture
