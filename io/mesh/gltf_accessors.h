// Numbers that a glTF document keeps in buffers.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/mesh/mesh_builder.h"

namespace kappamu::io {

struct Accessor {
  std::size_t count = 0;       ///< of elements
  std::vector<double> values;  ///< `count` times the parts of an element
};

class GltfAccessors {
 public:
  /// `binary` is the buffer of a .glb file. All outlive this object.
  GltfAccessors(const nlohmann::json& document, std::filesystem::path path,
                std::optional<std::span<const std::byte>> binary, const MeshBuilder& builder)
      : document_(document), path_(std::move(path)), binary_(binary), builder_(builder) {}

  /// Accessor number `index`, which must be of `parts` parts, with what its sparse part replaces;
  /// each read lies within its view, each view within its buffer. `use` is for sentences. Throws
  /// InputError.
  Accessor read(std::size_t index, const char* use, std::size_t parts, std::size_t most);

  /// A list of the object, an empty one where it has none.
  const nlohmann::json& list(const nlohmann::json& from, const char* field) const;
  /// The object number `index` of a list of the document.
  const nlohmann::json& at(const char* field, std::size_t index) const;
  /// Below 2^40, so that sums of products do not overflow.
  std::size_t number(const nlohmann::json& from, const char* field, std::size_t otherwise) const;

 private:
  struct Kind;
  [[noreturn]] void refuse(const std::string& what) const;
  std::span<const std::byte> buffer(std::size_t index);
  std::vector<std::byte> buffer_of(const std::string& uri) const;
  std::span<const std::byte> view(const nlohmann::json& from, std::size_t& stride);
  std::vector<double> stored(const nlohmann::json& from, const Kind& kind, std::size_t parts,
                             std::size_t count);

  const nlohmann::json& document_;
  std::filesystem::path path_;
  std::optional<std::span<const std::byte>> binary_;
  const MeshBuilder& builder_;
  std::map<std::size_t, std::vector<std::byte>> buffers_;
};

}  // namespace kappamu::io
