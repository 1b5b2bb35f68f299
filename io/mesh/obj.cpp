// Wavefront OBJ. Positions are read first, so that faces may stand before them.
#include <charconv>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "io/mesh/file_bytes.h"
#include "io/mesh/mesh_builder.h"
#include "io/mesh/mesh_formats.h"

namespace kappamu::io {

namespace {

/// Lines, of which those of vertices and faces are joined with the next where they end with '\'.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

  /// Its keyword and the words after it; false at the end of the file.
  bool next() {
    if (rest_.empty()) return false;
    number_ = ++read_;
    std::string_view line = next_line(rest_);
    words_ = line;
    keyword_ = next_word(words_);
    if (!continues(line) || keyword_.starts_with('#')) return true;
    joined_.assign(line);
    while (continues(joined_) && !rest_.empty()) {
      joined_[joined_.find_last_of('\\')] = ' ';
      joined_ += next_line(rest_);
      ++read_;
    }
    words_ = joined_;
    keyword_ = next_word(words_);
    return true;
  }
  std::size_t number() const { return number_; }  ///< from 1, of its beginning
  std::string_view keyword() const { return keyword_; }
  /// The next word of the line, an empty one at its end or comment.
  std::string_view word() {
    const std::string_view found = next_word(words_);
    if (found.starts_with('#')) words_ = {};
    return found.starts_with('#') ? std::string_view() : found;
  }
  std::string_view words() const { return words_; }

 private:
  static bool continues(std::string_view line) {
    const std::size_t last = line.find_last_not_of(" \t");
    return last != line.npos && line[last] == '\\';
  }

  std::string_view rest_, keyword_, words_;
  std::string joined_;
  std::size_t number_ = 0, read_ = 0;
};

class Obj {
 public:
  Obj(std::string_view text, const std::string& name) : text_(text), builder_(name, "line") {}

  FileMesh read() {
    for (Lines line(text_); line.next();) {
      if (line.keyword() == "v") vertex(line);
      if (line.keyword() == "vt") texture(line);
    }
    std::size_t before = 0, before_texture = 0;  // to which negative numbers are relative
    for (Lines line(text_); line.next();) {
      const std::string_view what = line.keyword();
      if (what == "v") ++before;
      if (what == "vt") ++before_texture;
      if (what == "f" || what == "fo") face(line, before, before_texture);
      if (what == "o" || what == "g") part(line);
      if (what == "l") builder_.leave_out("lines");
      if (what == "p") builder_.leave_out("points");
      if (what == "surf" || what == "curv" || what == "curv2") {
        builder_.leave_out("curves and surfaces of free form");
      }
    }
    return builder_.take();
  }

 private:
  [[noreturn]] void fail(const Lines& line, const std::string& what) const {
    builder_.fail("line " + std::to_string(line.number()) + " " + what + "; export it again");
  }

  void vertex(Lines& line) {
    Eigen::Vector3d position;
    for (double& coordinate : position) {
      const std::string_view word = line.word();
      const std::optional<double> number = finite_number(word);
      if (!number) fail(line, "gives a vertex the coordinate " + MeshBuilder::quoted(word));
      coordinate = *number;
    }
    // A lone fourth number is a weight, by which some programs divide and others do not.
    const std::string_view weight = line.word();
    if (!weight.empty() && line.word().empty() && finite_number(weight) != 1.0) {
      fail(line, "gives a vertex the weight " + MeshBuilder::quoted(weight) + ", not 1");
    }
    builder_.add_vertex(position);
  }

  /// v is 0 where a file of one dimension leaves it out; what is no number places nothing.
  void texture(Lines& line) {
    const std::string_view u = line.word(), v = line.word();
    const auto number = [](std::string_view word) {
      return static_cast<float>(
          finite_number(word).value_or(std::numeric_limits<double>::quiet_NaN()));
    };
    texture_.emplace_back(number(u), v.empty() ? 0.0F : number(v));
  }

  void face(Lines& line, std::size_t before, std::size_t before_texture) {
    corners_.clear();
    corner_texture_.clear();
    for (std::string_view word = line.word(); !word.empty(); word = line.word()) {
      corners_.push_back(corner(line, word, before));
      if (const auto number = texture_number(word, before_texture))
        corner_texture_.push_back(texture_[*number]);
      if (corners_.size() <= most_polygon_corners) continue;
      std::size_t more = corners_.size();
      while (!line.word().empty()) ++more;
      builder_.require_corners(more, line.number());
    }
    if (corner_texture_.size() != corners_.size()) corner_texture_.clear();
    builder_.add_polygon(corners_, line.number(), corner_texture_);
  }

  /// "7", "7/1", "7//3" or "7/1/3"; from 1, or from the last one, -1: vertex, texture coordinates
  /// and normal.
  int corner(const Lines& line, std::string_view word, std::size_t before) const {
    const std::string_view number = word.substr(0, word.find('/'));
    long long index = 0;
    const auto [end, error] = std::from_chars(number.begin(), number.end(), index);
    if (error != std::errc() || end != number.end()) {
      fail(line, "gives a face the corner " + MeshBuilder::quoted(word));
    }
    const auto count = static_cast<long long>(builder_.vertices());
    const long long vertex = index < 0 ? static_cast<long long>(before) + index : index - 1;
    if (index == 0 || vertex < 0 || vertex >= count) {
      fail(line, "names vertex " + std::to_string(index) + ", and the file has vertices 1 to " +
                     std::to_string(count));
    }
    return static_cast<int>(vertex);
  }

  /// None where the corner names no texture coordinates that are there.
  std::optional<std::size_t> texture_number(std::string_view word, std::size_t before) const {
    const std::size_t stroke = std::min(word.find('/'), word.size() - 1);
    const std::string_view number =
        word.substr(stroke + 1, word.find('/', stroke + 1) - stroke - 1);
    long long index = 0;
    const auto [end, error] = std::from_chars(number.begin(), number.end(), index);
    const long long found = index < 0 ? static_cast<long long>(before) + index : index - 1;
    const bool there = error == std::errc() && end == number.end() && index != 0 && found >= 0 &&
                       found < static_cast<long long>(texture_.size());
    return there ? std::optional<std::size_t>(found) : std::nullopt;
  }

  void part(Lines& line) {
    std::string_view rest = line.words();
    const std::size_t begin = std::min(rest.find_first_not_of(" \t"), rest.size());
    rest.remove_prefix(begin);
    rest = rest.substr(0, rest.find_last_not_of(" \t") + 1);
    const bool object = line.keyword() == "o";
    // Groups name parts where there are no objects.
    objects_ = objects_ || object;
    if (object || !objects_) builder_.begin_part(object ? "object" : "group", rest);
  }

  std::string_view text_;
  MeshBuilder builder_;
  std::vector<int> corners_;
  std::vector<Eigen::Vector2f> texture_, corner_texture_;
  bool objects_ = false;
};

}  // namespace

FileMesh read_obj(std::span<const std::byte> file, const std::string& name) {
  return Obj(text_of(file), name).read();
}

}  // namespace kappamu::io
