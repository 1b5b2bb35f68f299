// PLY: a header that declares elements and their properties, then these, as text or binary.
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/mesh/file_bytes.h"
#include "io/mesh/mesh_builder.h"
#include "io/mesh/mesh_formats.h"

namespace kappamu::io {

namespace {

enum class Kind { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
  std::string_view name;
  Kind kind = Kind::float32;
  std::optional<Kind> length;  ///< of a list
};

struct Element {
  std::string_view name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

constexpr std::size_t bytes_of(Kind kind) {
  constexpr std::array<std::size_t, 8> bytes{1, 1, 2, 2, 4, 4, 4, 8};
  return bytes[static_cast<std::size_t>(kind)];
}

class Ply {
 public:
  Ply(std::string_view text, const std::string& name)
      : rest_(text), size_(text.size()), builder_(name, "face") {}

  FileMesh read() {
    read_header();
    for (const Element& element : elements_) {
      if (element.name == "vertex") {
        read_vertices(element);
      } else if (element.name == "face") {
        read_faces(element);
      } else {
        for (std::size_t i = 0; i < element.count && !element.properties.empty(); ++i) {
          begin(element, i);
          for (const Property& property : element.properties) skip(property);
          end();
        }
      }
    }
    if (!ascii_ && !rest_.empty()) {
      builder_.note(std::to_string(rest_.size()) + " bytes after its last element left unread");
    } else if (!next_word(rest_).empty()) {
      fail("it holds more than its header declares");
    }
    std::size_t first = 0;
    std::vector<Eigen::Vector2f> texture;
    for (const auto& [face, corners] : faces_) {
      const std::span<const int> polygon = std::span(corners_).subspan(first, corners);
      texture.clear();
      if (!vertex_texture_.empty()) {
        for (const int v : polygon) texture.push_back(vertex_texture_[static_cast<std::size_t>(v)]);
      }
      builder_.add_polygon(polygon, face, texture);
      first += corners;
    }
    return builder_.take();
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    builder_.fail(what + "; export it again");
  }
  static std::string quoted(std::string_view word) { return MeshBuilder::quoted(word); }

  /// Data may begin with the byte of a line feed: the last line ends with CR LF only where one
  /// before it does.
  std::string_view header_line() {
    const std::size_t at = rest_.find_first_of("\r\n");
    if (at == rest_.npos) fail(lines_ == 0 ? "is no PLY file" : "its header has no end");
    const std::string_view line = rest_.substr(0, at);
    rest_.remove_prefix(at);
    const bool both = rest_.starts_with("\r\n") && (both_ || !line.starts_with("end_header"));
    rest_.remove_prefix(both ? 2 : 1);
    both_ = both_ || both;
    ++lines_;
    return line;
  }

  void read_header() {
    std::string_view first = header_line();
    if (next_word(first) != "ply") fail("is no PLY file");
    std::string_view format;
    constexpr int most_lines = 1000;
    while (lines_ < most_lines) {
      std::string_view line = header_line();
      const std::string_view what = next_word(line);
      if (what == "end_header") {
        if (format.empty()) fail("its header names no format");
        return;
      }
      if (what == "element") {
        add_element(line);
      } else if (what == "property") {
        add_property(line);
      } else if (what == "format") {
        if (!format.empty()) fail("its header names two formats");
        format = next_word(line);
        ascii_ = format == "ascii";
        const bool big = format == "binary_big_endian";
        if (!ascii_ && !big && format != "binary_little_endian") {
          fail("its header names format " + quoted(format) + ", which is none");
        }
        swapped_ = big != (std::endian::native == std::endian::big);
      } else if (!what.empty() && what != "comment" && what != "obj_info") {
        fail("its header has a line that begins with " + quoted(what));
      }
    }
    fail("its header has more than " + std::to_string(most_lines) + " lines");
  }

  void add_element(std::string_view line) {
    const std::string_view element = next_word(line), count = next_word(line);
    std::size_t declared = 0;
    const auto [end, error] = std::from_chars(count.begin(), count.end(), declared);
    if (error != std::errc() || end != count.end() || declared > size_) {
      fail("its header declares " + quoted(count) + " of element " + quoted(element) +
           ", which a file of " + std::to_string(size_) + " bytes cannot hold");
    }
    if (element == "tristrips" && declared > 0) {
      builder_.fail("its triangles are strips; export it again with faces");
    }
    for (const Element& known : elements_) {
      if (known.name == element) fail("its header declares element " + quoted(element) + " twice");
    }
    elements_.push_back({element, declared, {}});
  }

  Kind kind(std::string_view type) const {
    static constexpr std::array<std::pair<std::string_view, Kind>, 16> names{
        {{"char", Kind::int8},
         {"int8", Kind::int8},
         {"uchar", Kind::uint8},
         {"uint8", Kind::uint8},
         {"short", Kind::int16},
         {"int16", Kind::int16},
         {"ushort", Kind::uint16},
         {"uint16", Kind::uint16},
         {"int", Kind::int32},
         {"int32", Kind::int32},
         {"uint", Kind::uint32},
         {"uint32", Kind::uint32},
         {"float", Kind::float32},
         {"float32", Kind::float32},
         {"double", Kind::float64},
         {"float64", Kind::float64}}};
    for (const auto& [name, kind] : names) {
      if (name == type) return kind;
    }
    fail("its header names type " + quoted(type) + ", which is none");
  }

  void add_property(std::string_view line) {
    if (elements_.empty()) fail("its header has a property of no element");
    Property property;
    std::string_view type = next_word(line);
    if (type == "list") {
      property.length = kind(next_word(line));
      type = next_word(line);
    }
    property.kind = kind(type);
    property.name = next_word(line);
    for (const Property& known : elements_.back().properties) {
      if (known.name == property.name) {
        fail("its header declares property " + quoted(property.name) + " of an element twice");
      }
    }
    elements_.back().properties.push_back(property);
  }

  void read_vertices(const Element& element) {
    std::array<const Property*, 3> axes{};
    for (std::size_t k = 0; k < 3; ++k) {
      for (const Property& property : element.properties) {
        if (property.name == std::string_view("xyz").substr(k, 1)) axes[k] = &property;
      }
      if (axes[k] == nullptr || axes[k]->length) fail("its vertices lack x, y or z");
    }
    const std::array<const Property*, 2> texture = texture_properties(element);
    for (std::size_t i = 0; i < element.count; ++i) {
      begin(element, i);
      Eigen::Vector3d position;
      bool rounded = false;
      for (const Property& property : element.properties) {
        const auto axis = std::find(axes.begin(), axes.end(), &property) - axes.begin();
        if (&property == texture[0]) {
          vertex_texture_.emplace_back(value(property.kind), 0.0);
        } else if (axis == 3 && &property == texture[1]) {
          vertex_texture_.back()[1] = static_cast<float>(value(property.kind));
        } else if (axis == 3) {
          skip(property);
        }
        if (axis == 3) {
          continue;
        }
        position[axis] = value(property.kind);
        rounded = rounded || property.kind == Kind::float32;
      }
      end();
      if (!position.allFinite()) fail(here() + " has a coordinate that is not finite");
      if (rounded && !ascii_) builder_.rounded_to(float_step(position));
      builder_.add_vertex(position);
    }
  }

  /// The vertices' u and v, under the names that programs give them; none unless both are there, u
  /// before v.
  static std::array<const Property*, 2> texture_properties(const Element& element) {
    constexpr std::array<std::array<std::string_view, 2>, 3> names{
        {{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}}};
    for (const auto& name : names) {
      std::array<const Property*, 2> found{};
      for (const Property& property : element.properties) {
        if (property.length) continue;
        if (property.name == name[0]) found[0] = &property;
        if (property.name == name[1] && found[0] != nullptr) found[1] = &property;
      }
      if (found[1] != nullptr) return found;
    }
    return {};
  }

  /// Polygons are cut when all vertices are known: these may stand behind them.
  void read_faces(const Element& element) {
    const auto is_corners = [](const Property& property) {
      return property.length &&
             (property.name == "vertex_indices" || property.name == "vertex_index");
    };
    if (std::none_of(element.properties.begin(), element.properties.end(), is_corners)) {
      fail("its faces have no list vertex_indices");
    }
    const auto vertices = std::find_if(elements_.begin(), elements_.end(),
                                       [](const Element& e) { return e.name == "vertex"; });
    const double count = vertices == elements_.end() ? 0.0 : static_cast<double>(vertices->count);
    std::size_t triangles = 0;
    for (std::size_t i = 0; i < element.count; ++i) {
      begin(element, i);
      for (const Property& property : element.properties) {
        if (!is_corners(property)) {
          skip(property);
          continue;
        }
        const std::size_t corners = length(property);
        builder_.require_corners(corners, i);
        triangles += std::max<std::size_t>(corners, 2) - 2;
        if (triangles > most_triangles) {
          builder_.fail("has more than " + std::to_string(most_triangles) +
                        " triangles; decimate the mesh");
        }
        for (std::size_t k = 0; k < corners; ++k) {
          const double vertex = value(property.kind);
          if (!(vertex >= 0.0 && vertex < count) || vertex != std::floor(vertex)) {
            fail(here() + " names vertex " + shown_vertex(vertex) + ", and there are " +
                 std::to_string(static_cast<std::size_t>(count)) + ", from 0");
          }
          corners_.push_back(static_cast<int>(vertex));
        }
        if (corners < 3) {
          builder_.leave_out("faces of fewer than three corners");
          corners_.resize(corners_.size() - corners);
        } else {
          faces_.emplace_back(i, corners);
        }
      }
      end();
    }
  }
  static std::string shown_vertex(double vertex) {
    const std::string shown = std::to_string(vertex);
    return vertex == std::floor(vertex) ? shown.substr(0, shown.find('.')) : shown;
  }

  /// Of an element's instance: a line of a text, whose empty ones are passed over.
  void begin(const Element& element, std::size_t number) {
    element_ = &element;
    number_ = number;
    if (!ascii_) return;
    do {
      if (rest_.empty()) fail("it ends before what its header declares, in " + here());
      line_ = next_line(rest_);
    } while (line_.find_first_not_of(" \t\v\f") == line_.npos);
  }
  void end() {
    if (ascii_ && !next_word(line_).empty()) {
      fail("the line of " + here() + " holds more than its header declares");
    }
  }
  std::string here() const {
    return std::string(element_->name.substr(0, 40)) + " " + std::to_string(number_);
  }

  void skip(const Property& property) {
    const std::size_t values = property.length ? length(property) : 1;
    if (ascii_) {
      for (std::size_t k = 0; k < values; ++k) word();
    } else {
      bytes(values * bytes_of(property.kind));
    }
  }
  std::size_t length(const Property& list) {
    const double length = value(*list.length);
    if (!(length >= 0.0) || length != std::floor(length) || length > static_cast<double>(size_)) {
      fail("a list of " + here() + " has " + shown_vertex(length) + " values");
    }
    return static_cast<std::size_t>(length);
  }

  /// NaN where a text has no number: of what is of no use here, it does no harm.
  double value(Kind kind) {
    if (ascii_) {
      return finite_number(word()).value_or(std::numeric_limits<double>::quiet_NaN());
    }
    switch (kind) {
      case Kind::int8:
        return stored<std::int8_t>();
      case Kind::uint8:
        return stored<std::uint8_t>();
      case Kind::int16:
        return stored<std::int16_t>();
      case Kind::uint16:
        return stored<std::uint16_t>();
      case Kind::int32:
        return stored<std::int32_t>();
      case Kind::uint32:
        return stored<std::uint32_t>();
      case Kind::float32:
        return stored<float>();
      case Kind::float64:
        return stored<double>();
    }
    return 0.0;
  }
  template <class T>
  T stored() {
    std::array<char, sizeof(T)> order{};
    const std::string_view taken = bytes(sizeof(T));
    std::copy(taken.begin(), taken.end(), order.begin());
    if (swapped_) std::reverse(order.begin(), order.end());
    return std::bit_cast<T>(order);
  }
  std::string_view word() {
    const std::string_view next = next_word(line_);
    if (next.empty()) fail("the line of " + here() + " holds less than its header declares");
    return next;
  }
  std::string_view bytes(std::size_t count) {
    if (count > rest_.size()) fail("it ends before what its header declares, in " + here());
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }

  std::string_view rest_, line_;  ///< `line_`: of a text's body, what is left of it
  int lines_ = 0;                 ///< of the header
  bool both_ = false;             ///< CR and LF end one of them
  std::size_t size_;
  MeshBuilder builder_;
  bool ascii_ = true, swapped_ = false;
  std::vector<Element> elements_;
  const Element* element_ = nullptr;
  std::size_t number_ = 0;  ///< of the instance being read
  std::vector<int> corners_;
  std::vector<Eigen::Vector2f> vertex_texture_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> faces_;  ///< number, corners
};

}  // namespace

FileMesh read_ply(std::span<const std::byte> file, const std::string& name) {
  return Ply(text_of(file), name).read();
}

}  // namespace kappamu::io
