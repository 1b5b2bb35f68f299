// glTF 2.0 (Khronos 2021): what places triangles. Sections 3.6 (buffers, views, accessors), 3.5
// (nodes and their transforms), 3.7.2 (primitives), 4 (binary files).
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/mesh/file_bytes.h"
#include "io/mesh/gltf_accessors.h"
#include "io/mesh/mesh_builder.h"
#include "io/mesh/mesh_formats.h"

namespace kappamu::io {

namespace {

using nlohmann::json;

constexpr std::uint32_t magic = 0x46546C67, json_kind = 0x4E4F534A, binary_kind = 0x004E4942;
constexpr std::size_t glb_header = 12, chunk_header = 8;

/// Extensions that change no position: a file may require them.
bool places_nothing(std::string_view extension) {
  return extension.starts_with("KHR_materials_") || extension.starts_with("KHR_texture_") ||
         extension.starts_with("EXT_texture_") || extension == "KHR_lights_punctual" ||
         extension == "KHR_mesh_quantization";
}

class Gltf {
 public:
  Gltf(std::span<const std::byte> file, const std::filesystem::path& path,
       std::span<const double> morph)
      : builder_(path.string(), "triangle"), morph_(morph) {
    std::span<const std::byte> text = file;
    std::optional<std::span<const std::byte>> binary;
    if (file.size() >= 4 && word_at(file, 0) == magic) {
      text = chunks(file, binary);
    }
    json_ = json::parse(text_of(text), nullptr, false);
    if (!json_.is_object()) refuse("its glTF is not a JSON object");
    check_version();
    accessors_.emplace(json_, path, binary, builder_);
  }

  FileMesh read() {
    for (const std::size_t node : roots()) place(node, Eigen::Affine3d::Identity(), 0);
    builder_.rounded_to(step_);
    if (skinned_) builder_.note("its skin is left out: the body stands as its positions do");
    if (morphed_ && morph_.empty())
      builder_.note("its morph targets are left out, whose weights are not all 0");
    return builder_.take();
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    builder_.fail(what + "; export it again");
  }

  /// The JSON of a .glb file, its first chunk, and the buffer after it.
  std::span<const std::byte> chunks(std::span<const std::byte> file,
                                    std::optional<std::span<const std::byte>>& binary) const {
    constexpr std::size_t start = glb_header + chunk_header;
    if (file.size() < start || word_at(file, 4) != 2 || word_at(file, 16) != json_kind) {
      refuse("is no binary glTF file of version 2");
    }
    if (word_at(file, 8) > file.size() || word_at(file, 12) > file.size() - start) {
      refuse("is cut short");
    }
    const std::size_t length = word_at(file, 12);
    std::span<const std::byte> rest = file.subspan(start + length);
    if (rest.size() >= chunk_header && word_at(rest, 4) == binary_kind) {
      if (word_at(rest, 0) > rest.size() - chunk_header) refuse("is cut short");
      binary = rest.subspan(chunk_header, word_at(rest, 0));
    }
    return file.subspan(start, length);
  }

  void check_version() const {
    const json asset = json_.value("asset", json::object());
    const json version = asset.is_object() ? asset.value("version", json()) : json();
    if (!version.is_string() || !version.get<std::string>().starts_with("2.")) {
      refuse("is not of version 2 of glTF");
    }
    if (!json_.contains("extensionsRequired")) return;
    for (const json& extension : json_["extensionsRequired"]) {
      const std::string name = extension.is_string() ? extension.get<std::string>() : "";
      if (places_nothing(name)) continue;
      builder_.fail("needs the glTF extension " + MeshBuilder::quoted(name) +
                    "; export it without extensions");
    }
  }

  const json& list(const char* field) const { return accessors_->list(json_, field); }
  std::size_t number(const json& from, const char* field, std::size_t otherwise) const {
    return accessors_->number(from, field, otherwise);
  }
  const json& at(const char* field, std::size_t index) const {
    return accessors_->at(field, index);
  }

  /// Of the scene that the file shows; of no scene, nodes that are nobody's child.
  std::vector<std::size_t> roots() {
    if (!list("scenes").empty()) {
      if (list("scenes").size() > 1) {
        builder_.note("of its " + std::to_string(list("scenes").size()) +
                      " scenes, the one it shows first is read");
      }
      return indices(at("scenes", number(json_, "scene", 0)), "nodes");
    }
    std::vector<bool> child(list("nodes").size());
    for (const json& node : list("nodes")) {
      for (const std::size_t index : indices(node, "children")) {
        if (index < child.size()) child[index] = true;
      }
    }
    std::vector<std::size_t> result;
    for (std::size_t n = 0; n < child.size(); ++n) {
      if (!child[n]) result.push_back(n);
    }
    return result;
  }
  std::vector<std::size_t> indices(const json& from, const char* field) const {
    std::vector<std::size_t> result;
    for (const json& value : accessors_->list(from, field)) {
      if (!value.is_number_unsigned())
        refuse(std::string(field) + " of its glTF is no list of numbers");
      result.push_back(value.get<std::size_t>());
    }
    return result;
  }
  template <std::size_t N>
  std::optional<std::array<double, N>> numbers(const json& node, const char* field) const {
    if (!node.contains(field)) return std::nullopt;
    const json& values = accessors_->list(node, field);
    std::array<double, N> result{};
    for (std::size_t k = 0; k < N; ++k) {
      if (values.size() != N || !values[k].is_number()) {
        refuse(std::string(field) + " of a node of its glTF is not " + std::to_string(N) +
               " numbers");
      }
      result[k] = values[k].get<double>();
    }
    return result;
  }

  /// parent_from_node.
  Eigen::Affine3d transform(const json& node) const {
    Eigen::Affine3d result = Eigen::Affine3d::Identity();
    if (const auto m = numbers<16>(node, "matrix")) {
      result.matrix() = Eigen::Matrix4d(m->data());  // by columns
      return result;
    }
    if (const auto t = numbers<3>(node, "translation")) {
      result.translate(Eigen::Vector3d(t->data()));
    }
    if (const auto r = numbers<4>(node, "rotation")) {
      result.rotate(Eigen::Quaterniond((*r)[3], (*r)[0], (*r)[1], (*r)[2]).normalized());
    }
    if (const auto s = numbers<3>(node, "scale")) result.scale(Eigen::Vector3d(s->data()));
    return result;
  }

  void place(std::size_t index, const Eigen::Affine3d& parent, int depth) {
    constexpr int deepest = 100;
    constexpr std::size_t most_nodes = 100'000;
    if (depth > deepest || ++placed_ > most_nodes) {
      refuse("the nodes of its glTF are too many, or children of themselves");
    }
    const json& node = at("nodes", index);
    const Eigen::Affine3d world_from_node = parent * transform(node);
    if (node.contains("extensions") && node["extensions"].is_object() &&
        node["extensions"].contains("EXT_mesh_gpu_instancing")) {
      builder_.fail("repeats a mesh by extension EXT_mesh_gpu_instancing; export it without");
    }
    if (node.contains("mesh")) {
      skinned_ = skinned_ || node.contains("skin");
      const json& mesh = at("meshes", number(node, "mesh", 0));
      const json& own = node.contains("name") ? node : mesh;
      const json& weights = accessors_->list(node.contains("weights") ? node : mesh, "weights");
      morphed_ = morphed_ ||
                 std::any_of(weights.begin(), weights.end(), [](const json& w) { return w != 0; });
      const json name = own.value("name", json(""));
      builder_.begin_part(&own == &node ? "node" : "mesh",
                          name.is_string() ? name.get<std::string>() : "");
      if (accessors_->list(mesh, "primitives").empty()) {
        refuse("a mesh of its glTF has no primitives");
      }
      for (const json& primitive : accessors_->list(mesh, "primitives")) {
        place_primitive(primitive, world_from_node);
      }
    }
    for (const std::size_t child : indices(node, "children"))
      place(child, world_from_node, depth + 1);
  }

  /// Morph targets by the weights that were asked for.
  void add_targets(const json& primitive, Accessor& positions) {
    if (morph_.empty()) return;
    const json& targets = accessors_->list(primitive, "targets");
    if (targets.size() != morph_.size()) {
      builder_.fail("has " + std::to_string(targets.size()) + " morph targets and " +
                    std::to_string(morph_.size()) + " weights; write one for each");
    }
    for (std::size_t t = 0; t < targets.size(); ++t) {
      if (morph_[t] == 0.0 || !targets[t].is_object() || !targets[t].contains("POSITION")) continue;
      const Accessor moves =
          accessors_->read(number(targets[t], "POSITION", 0), "POSITION", 3, most_triangles * 3);
      if (moves.count != positions.count) refuse("a morph target of its glTF is of another mesh");
      for (std::size_t i = 0; i < positions.values.size(); ++i) {
        positions.values[i] += morph_[t] * moves.values[i];
      }
    }
  }

  void place_primitive(const json& primitive, const Eigen::Affine3d& world_from_node) {
    if (!primitive.is_object() || !primitive.contains("attributes")) {
      refuse("a primitive of its glTF has no attributes");
    }
    constexpr std::size_t triangle_list = 4, strip = 5, fan = 6;
    const std::size_t mode = number(primitive, "mode", triangle_list);
    if (mode > fan) refuse("a primitive of its glTF is of no known mode");
    if (mode < triangle_list) {
      return builder_.leave_out(mode == 0 ? "primitives of points" : "primitives of lines");
    }
    const std::size_t accessor =
        number(primitive["attributes"], "POSITION", list("accessors").size());
    Accessor positions = accessors_->read(accessor, "POSITION", 3, most_triangles * 3);
    add_targets(primitive, positions);
    const double stretch = world_from_node.linear().cwiseAbs().maxCoeff();
    const int first = static_cast<int>(builder_.vertices());
    for (std::size_t v = 0; v < positions.count; ++v) {
      const Eigen::Vector3d position(&positions.values[3 * v]);
      const Eigen::Vector3d placed = world_from_node * position;
      if (!placed.allFinite()) {
        refuse("position " + std::to_string(v) + " of accessor " + std::to_string(accessor) +
               " of its glTF is not finite");
      }
      step_ = std::max(step_, stretch * float_step(position));
      builder_.add_vertex(placed);
    }
    const std::vector<Eigen::Vector2f> texture = texture_of(primitive, positions.count);
    std::vector<double> corners;
    if (primitive.contains("indices")) {
      corners = accessors_->read(number(primitive, "indices", 0), "indices", 1, most_triangles * 3)
                    .values;
    } else {
      for (std::size_t v = 0; v < positions.count; ++v) corners.push_back(static_cast<double>(v));
    }
    const auto corner = [&](std::size_t k) {
      if (!(corners[k] < static_cast<double>(positions.count))) {
        refuse("triangle " + std::to_string(triangles_) + " of its glTF names vertex " +
               std::to_string(static_cast<std::size_t>(corners[k])) + ", and its positions are " +
               std::to_string(positions.count) + ", from 0");
      }
      return first + static_cast<int>(corners[k]);
    };
    if (mode == triangle_list && corners.size() % 3 != 0) {
      refuse("a primitive of its glTF has " + std::to_string(corners.size()) +
             " corners, which are no whole triangles");
    }
    const bool mirrored = world_from_node.linear().determinant() < 0.0;
    const std::size_t step = mode == triangle_list ? 3 : 1;
    for (std::size_t k = 0; k + 3 <= corners.size(); k += step) {
      const bool odd = mode == strip && k % 2 == 1;
      std::array<int, 3> triangle{corner(mode == fan ? 0 : k), corner(k + 1), corner(k + 2)};
      if (odd != mirrored) std::swap(triangle[1], triangle[2]);
      CornerTexture placed;
      for (std::size_t i = 0; i < 3 && !texture.empty(); ++i)
        placed[i] = texture[static_cast<std::size_t>(triangle[i] - first)];
      builder_.add_polygon(triangle, triangles_++,
                           texture.empty() ? std::span<const Eigen::Vector2f>() : placed);
    }
  }

  /// TEXCOORD_0, one pair per position; empty where the primitive has none.
  std::vector<Eigen::Vector2f> texture_of(const json& primitive, std::size_t positions) {
    std::vector<Eigen::Vector2f> texture;
    if (!primitive["attributes"].contains("TEXCOORD_0")) return texture;
    const std::size_t accessor =
        number(primitive["attributes"], "TEXCOORD_0", list("accessors").size());
    const Accessor read = accessors_->read(accessor, "TEXCOORD_0", 2, most_triangles * 3);
    if (read.count != positions) {
      refuse("a primitive of its glTF has " + std::to_string(read.count) +
             " texture coordinates and " + std::to_string(positions) + " positions");
    }
    for (std::size_t v = 0; v < read.count; ++v) {
      texture.emplace_back(static_cast<float>(read.values[2 * v]),
                           static_cast<float>(read.values[2 * v + 1]));
    }
    return texture;
  }

  MeshBuilder builder_;
  json json_;
  std::optional<GltfAccessors> accessors_;
  std::size_t placed_ = 0, triangles_ = 0;
  double step_ = 0.0;
  bool skinned_ = false, morphed_ = false;
  std::span<const double> morph_;
};

}  // namespace

FileMesh read_gltf(std::span<const std::byte> file, const std::filesystem::path& path,
                   std::span<const double> morph) {
  return Gltf(file, path, morph).read();
}

}  // namespace kappamu::io
