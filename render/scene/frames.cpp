#include "render/scene/frames.h"

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/shown_text.h"
#include "io/json_node.h"
#include "io/read_file.h"

namespace kappamu::render {

namespace {

using nlohmann::json;

constexpr int most_frames = 100'000;
constexpr const char* hint = "docs/howto/animate.md";

/// "lights[0].position_mm" as messages write it, as a JSON pointer.
json::json_pointer pointer_of(const io::JsonNode& node) {
  const std::string field = node.text();
  std::string pointer = "/";
  for (const char c : field) {
    if (c == ']') continue;
    pointer += c == '.' || c == '[' ? '/' : c;
  }
  if (field.empty() || pointer.find('~') != std::string::npos) {
    node.fail("is no field of a scene; write it as lights[0].position_mm");
  }
  return json::json_pointer(pointer);
}

/// Between two values of the same form, each number on its own.
json between(const json& one, const json& other, double share) {
  if (one.is_number()) {
    return one.get<double>() + share * (other.get<double>() - one.get<double>());
  }
  json list = json::array();
  for (std::size_t i = 0; i < one.size(); ++i) list.push_back(between(one[i], other[i], share));
  return list;
}

bool numeric(const json& value) {
  return value.is_number() ||
         (value.is_array() && !value.empty() && std::all_of(value.begin(), value.end(), numeric));
}

/// Whether between() can go from one to the other.
bool alike(const json& one, const json& other) {
  if (!numeric(one) || !numeric(other)) return false;
  if (one.is_number() || other.is_number()) return one.is_number() && other.is_number();
  return one.size() == other.size() && std::equal(one.begin(), one.end(), other.begin(), alike);
}

using Between = Frames::Between;
constexpr Names<Between, 3> between_names{
    {{"linear", Between::linear}, {"smooth", Between::smooth}, {"step", Between::step}}};

/// A file's name with its # replaced by the number, filled with zeros.
std::string numbered(const std::string& pattern, int number) {
  const std::size_t first = pattern.find('#'), last = pattern.find_last_of('#');
  return pattern.substr(0, first) + formatted("%0*d", static_cast<int>(last - first + 1), number) +
         pattern.substr(last + 1);
}

}  // namespace

/// A field and its values at some frames, or a sequence of files.
struct Frames::Track {
  json::json_pointer field;
  Between between = Between::linear;
  std::vector<std::pair<int, json>> keys{};
  std::string files{};
  int first_file = 0;

  json at(int frame) const {
    if (keys.empty()) return numbered(files, first_file + frame);
    const auto after =
        std::find_if(keys.begin(), keys.end(), [&](const auto& key) { return key.first > frame; });
    if (after == keys.begin()) return after->second;
    const auto before = after - 1;
    if (after == keys.end() || between == Between::step) return before->second;
    double share = static_cast<double>(frame - before->first) / (after->first - before->first);
    if (between == Between::smooth) share *= share * (3.0 - 2.0 * share);
    return render::between(before->second, after->second, share);
  }
};

namespace {

json scene_json(const std::filesystem::path& scene) {
  read_scene(scene);  // refused by its own reader
  return json::parse(io::read_text(scene));
}

}  // namespace

Frames::Frames(const std::filesystem::path& scene, const std::filesystem::path& file)
    : scene_(scene), json_(std::make_unique<json>(scene_json(scene))) {
  const io::JsonDocument document(file, hint, io::JsonComments::allowed);
  const io::JsonNode root = document.root();
  root.expect_fields({"format", "version", "frames", "tracks"}, {"rate"});
  root.expect_format("kappamu-frames");
  root["frames"].number_between(1, most_frames);
  count_ = root["frames"].integer();
  if (root.has("rate")) rate_ = root["rate"].number_between(0.1, 1000.0);
  const json raw = json::parse(io::read_text(file));
  std::size_t t = 0;
  for (const io::JsonNode& node : root["tracks"].items(1)) {
    const json& track = raw["tracks"][t++];
    if (node.has("keys") == node.has("files")) {
      node.fail("must have either 'keys' or 'files', a name with # for the frame's number");
    }
    tracks_.push_back({pointer_of(node["field"])});
    Track& made = tracks_.back();
    const json::json_pointer parent = made.field.parent_pointer();
    if (!json_->contains(parent) || (*json_)[parent].is_primitive() ||
        ((*json_)[parent].is_array() && !json_->contains(made.field))) {
      node["field"].fail("is no field of " + scene.string());
    }
    if (node.has("files")) {
      node.expect_fields({"field", "files"}, {"first"});
      made.files = node["files"].text();
      const std::size_t first = made.files.find('#'), last = made.files.find_last_of('#');
      if (first == std::string::npos || made.files.find_first_not_of('#', first) < last) {
        node["files"].fail("has no run of # for the frame's number");
      }
      if (node.has("first")) made.first_file = node["first"].integer();
      continue;
    }
    node.expect_fields({"field", "keys"}, {"between"});
    if (node.has("between")) made.between = node["between"].named(between_names);
    std::size_t k = 0;
    for (const io::JsonNode& key : node["keys"].items(1)) {
      const std::vector<io::JsonNode> both = key.exactly(2);
      both[0].number_between(0, most_frames);
      const int frame = both[0].integer();
      json value = track["keys"][k++][1];
      if (!made.keys.empty()) {
        if (frame <= made.keys.back().first) both[0].fail("is not after the frame before it");
        if (made.between != Between::step && !alike(made.keys.back().second, value)) {
          both[1].fail(
              "does not go on from the value before it; write numbers of one form, or "
              "\"between\": \"step\"");
        }
      }
      made.keys.emplace_back(frame, std::move(value));
    }
  }
}

Frames::Frames(const std::filesystem::path& scene, int count)
    : scene_(scene), json_(std::make_unique<json>(scene_json(scene))), count_(count) {
  const Camera camera = read_scene(scene).camera;
  tracks_.push_back({json::json_pointer("/camera/position_mm"), Between::step});
  for (int frame = 0; frame < count; ++frame) {
    const Eigen::AngleAxisd turn(2.0 * std::numbers::pi * frame / count, camera.up.normalized());
    const Eigen::Vector3d at = camera.target_mm + turn * (camera.position_mm - camera.target_mm);
    tracks_.back().keys.emplace_back(frame, json{at.x(), at.y(), at.z()});
  }
}

Frames::~Frames() = default;

std::string Frames::text(int frame) const {
  json scene = *json_;
  for (const Track& track : tracks_) scene[track.field] = track.at(frame);
  return scene.dump();
}

Scene Frames::scene(int frame) const {
  return read_scene(text(frame), scene_, " at frame " + std::to_string(frame));
}

}  // namespace kappamu::render
