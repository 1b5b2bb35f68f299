// STL, text or binary.
#include <array>
#include <cctype>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/mesh/file_bytes.h"
#include "io/mesh/mesh_builder.h"
#include "io/mesh/mesh_formats.h"

namespace kappamu::io {

namespace {

constexpr std::size_t header = 84, facet = 50;

bool is_word(std::string_view word, std::string_view lower) {
  return std::equal(word.begin(), word.end(), lower.begin(), lower.end(), [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == b;
  });
}

/// Headers of binary files may begin with "solid" too, as long as their size is not that of the
/// triangles which they declare: then numbers follow, and hold zeros.
bool is_text(std::span<const std::byte> file) {
  std::string_view text = text_of(file);
  if (file.size() >= header && file.size() == header + facet * word_at(file, header - 4)) {
    return false;
  }
  if (text.substr(0, header).find('\0') != text.npos) return false;
  return is_word(next_word(text), "solid");
}

FileMesh read_text(std::string_view text, const std::string& name) {
  MeshBuilder builder(name, "line");
  std::vector<int> corners;
  std::size_t number = 0, facet_line = 0;  // 0: outside of a facet
  bool ended = false;
  const auto fail = [&](const std::string& what) {
    builder.fail("line " + std::to_string(number) + " " + what + "; export it again");
  };
  while (!text.empty()) {
    std::string_view line = next_line(text);
    ++number;
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      if (is_word(word, "solid")) {
        const std::string_view title = next_word(line);
        builder.begin_part("solid", title);
        line = {};
      } else if (is_word(word, "endsolid")) {
        ended = true;
        line = {};
      } else if (is_word(word, "normal")) {
        for (int k = 0; k < 3; ++k) next_word(line);
      } else if (is_word(word, "facet")) {
        if (facet_line > 0) fail("begins a facet in that of line " + std::to_string(facet_line));
        facet_line = number;
        corners.clear();
      } else if (is_word(word, "vertex")) {
        if (facet_line == 0) fail("has a vertex of no facet");
        Eigen::Vector3d position;
        for (double& coordinate : position) {
          const std::string_view given = next_word(line);
          const std::optional<double> value = finite_number(given);
          if (!value) fail("gives a vertex the coordinate " + MeshBuilder::quoted(given));
          coordinate = *value;
        }
        corners.push_back(static_cast<int>(builder.vertices()));
        builder.add_vertex(position);
      } else if (is_word(word, "endfacet")) {
        if (facet_line == 0 || corners.size() != 3) {
          fail("ends a facet of " + std::to_string(corners.size()) + " vertices");
        }
        builder.add_polygon(corners, facet_line);
        facet_line = 0;
      } else if (!is_word(word, "outer") && !is_word(word, "loop") && !is_word(word, "endloop")) {
        line = {};  // of no meaning in STL: colours
      }
    }
  }
  if (facet_line > 0) {
    builder.fail("is cut short: the facet of line " + std::to_string(facet_line) +
                 " does not end; copy or export it again");
  }
  if (builder.vertices() == 0 && !ended)
    builder.fail("is cut short: it has no facet; copy it again");
  return builder.take();
}

FileMesh read_binary(std::span<const std::byte> file, const std::string& name) {
  MeshBuilder builder(name, "triangle");
  if (file.size() < header) builder.fail("is no STL file, or is cut short; export it again");
  const std::size_t declared = word_at(file, header - 4), whole = header + facet * declared;
  if (file.size() < whole) {
    builder.fail("is cut short, or no STL file: its header declares " + std::to_string(declared) +
                 " triangles, " + std::to_string(whole) + " bytes, and the file has " +
                 std::to_string(file.size()) + "; copy or export it again");
  }
  if (file.size() > whole) {
    const std::size_t more = file.size() - whole;
    if (declared == 0 || (more >= facet && more % facet == 0)) {
      builder.fail("its header declares " + std::to_string(declared) +
                   " triangles, and the file has "
                   "bytes for " +
                   std::to_string((file.size() - header) / facet) + "; export it again");
    }
    builder.note(std::to_string(more) + " bytes after its last triangle left unread");
  }
  for (std::size_t t = 0; t < declared; ++t) {
    const int first = static_cast<int>(builder.vertices());
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<float, 3> stored{};
      std::memcpy(stored.data(), file.data() + header + facet * t + 12 * (k + 1), sizeof stored);
      const Eigen::Vector3d position(stored[0], stored[1], stored[2]);
      if (!position.allFinite()) {
        builder.fail("triangle " + std::to_string(t) +
                     " has a coordinate that is not finite; export it again");
      }
      builder.rounded_to(float_step(position));
      builder.add_vertex(position);
    }
    const std::array<int, 3> corners{first, first + 1, first + 2};
    builder.add_polygon(corners, t);
  }
  return builder.take();
}

}  // namespace

FileMesh read_stl(std::span<const std::byte> file, const std::string& name) {
  return is_text(file) ? read_text(text_of(file), name) : read_binary(file, name);
}

}  // namespace kappamu::io
