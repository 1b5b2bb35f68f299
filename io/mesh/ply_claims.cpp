#include "io/mesh/ply_claims.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <vector>

#include "core/error.h"
#include "io/mesh/file_bytes.h"
#include "io/mesh_file.h"

namespace kappamu::io {

namespace {

struct Property {
  std::size_t bytes = 0;         ///< of a value
  std::size_t length_bytes = 0;  ///< of a list's length; 0: no list
};

struct Element {
  std::string_view name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

/// The whole word as a number, if it is one.
std::optional<std::size_t> whole(std::string_view word) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(word.begin(), word.end(), value);
  if (error != std::errc() || end != word.end()) return std::nullopt;
  return value;
}

class Ply {
 public:
  Ply(std::string_view text, const std::string& name)
      : rest_(text), size_(text.size()), name_(name) {}

  MeshClaims claims() {
    read_header();
    MeshClaims claims;
    for (const Element& element : elements_) {
      if (element.name == "vertex") claims.vertices = element.count;
      if (element.name == "face") claims.triangles = element.count;
      for (std::size_t i = 0; i < element.count; ++i) walk(element);
    }
    return claims;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(name_ + ": " + what + "; export it again");
  }
  static std::string quoted(std::string_view word) {
    return "'" + std::string(word.substr(0, 24)) + "'";
  }

  void read_header() {
    if (next_line(rest_).substr(0, 3) != "ply") fail("is no PLY file");
    std::size_t instances = 0;
    constexpr int most_lines = 1000;
    for (int number = 0; number < most_lines && !rest_.empty(); ++number) {
      std::string_view line = next_line(rest_);
      const std::string_view what = next_word(line);
      if (what == "end_header") {
        if (instances > size_) break;  // of a byte at the least
        return;
      }
      if (what == "element") {
        add_element(line);
        instances += elements_.back().count;
      } else if (what == "property") {
        add_property(line);
      } else if (what == "format") {
        const std::string_view format = next_word(line);
        if (!format_.empty()) fail("its header names two formats");
        format_ = format;
        ascii_ = format == "ascii";
        big_ = format == "binary_big_endian";
        if (!ascii_ && !big_ && format != "binary_little_endian") {
          fail("its header names format " + quoted(format) + ", which is none");
        }
      } else if (!what.empty() && what != "comment" && what != "obj_info") {
        fail("its header has a line that begins with " + quoted(what));
      }
    }
    fail("its header has no end, or declares more than the file holds");
  }

  void add_element(std::string_view line) {
    const std::string_view element = next_word(line), count = next_word(line);
    const std::optional<std::size_t> declared = whole(count);
    if (!declared || *declared > size_) {
      fail("its header declares " + quoted(count) + " of element " + quoted(element) +
           ", which a file of " + std::to_string(size_) + " bytes cannot hold");
    }
    if (element == "tristrips") {
      throw InputError(name_ + ": its triangles are strips; export it again with faces");
    }
    // Assimp 5.2 makes room for the first of a kind and writes those of a second one behind it.
    for (const Element& known : elements_) {
      if (known.name == element) fail("its header declares element " + quoted(element) + " twice");
    }
    elements_.push_back({element, *declared, {}});
  }

  void add_property(std::string_view line) {
    const auto bytes_of = [&](std::string_view type) {
      static const std::map<std::string_view, std::size_t> types{
          {"char", 1},   {"int8", 1},    {"uchar", 1},  {"uint8", 1},  {"short", 2}, {"int16", 2},
          {"ushort", 2}, {"uint16", 2},  {"int", 4},    {"int32", 4},  {"uint", 4},  {"uint32", 4},
          {"float", 4},  {"float32", 4}, {"double", 8}, {"float64", 8}};
      const auto found = types.find(type);
      if (found == types.end()) fail("its header names type " + quoted(type) + ", which is none");
      return found->second;
    };
    if (elements_.empty()) fail("its header has a property of no element");
    Property property;
    std::string_view type = next_word(line);
    if (type == "list") {
      const std::string_view length = next_word(line);
      property.length_bytes = bytes_of(length);
      if (length.starts_with("float") || length == "double") {
        fail("its header gives a list a length of type " + quoted(length));
      }
      type = next_word(line);
    }
    property.bytes = bytes_of(type);
    elements_.back().properties.push_back(property);
  }

  void walk(const Element& element) {
    if (ascii_) take_line();
    for (const Property& property : element.properties) walk(property);
    if (ascii_ && !next_word(line_).empty()) {
      fail("a line holds more than its header declares of a " + quoted(element.name));
    }
  }

  /// Assimp ends a line at these characters too, and passes over one that begins with `comment`.
  void take_line() {
    line_ = next_line(rest_);
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    if (std::ranges::any_of(line_, [](char c) { return c == '\r' || c == '\f' || c == '\0'; })) {
      fail("a line holds a control character");
    }
    std::string_view begin = line_;
    if (next_word(begin).starts_with("comment")) fail("a comment stands among its values");
  }

  void walk(const Property& property) {
    std::size_t values = 1;
    if (property.length_bytes > 0) {
      values = length(property.length_bytes);
      if (values > most_polygon_corners) {
        throw InputError(name_ + ": a polygon or list has " + std::to_string(values) +
                         " values; at most " + std::to_string(most_polygon_corners) +
                         " are taken, triangulate the mesh");
      }
    }
    if (ascii_) {
      for (std::size_t k = 0; k < values; ++k) word();
    } else {
      bytes(values * property.bytes);
    }
  }

  std::size_t length(std::size_t size) {
    if (ascii_) {
      const std::string_view text = word();
      const std::optional<std::size_t> value = whole(text);
      if (!value) fail("a list's length is " + quoted(text));
      return *value;
    }
    const std::string_view stored = bytes(size);
    std::size_t value = 0;
    for (std::size_t k = 0; k < size; ++k) {
      value = value << 8 | static_cast<unsigned char>(stored[big_ ? k : size - 1 - k]);
    }
    return value;
  }

  std::string_view word() {
    const std::string_view next = next_word(line_);
    if (next.empty()) fail("it ends, or a line does, before what its header declares");
    return next;
  }
  std::string_view bytes(std::size_t count) {
    if (count > rest_.size()) fail("it ends before what its header declares");
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }

  std::string_view rest_, format_, line_;  ///< `line_`: of the body, what is left of it
  std::size_t size_;
  const std::string& name_;
  bool ascii_ = true, big_ = false;
  std::vector<Element> elements_;
};

}  // namespace

MeshClaims ply_claims(std::string_view text, const std::string& name) {
  return Ply(text, name).claims();
}

}  // namespace kappamu::io
