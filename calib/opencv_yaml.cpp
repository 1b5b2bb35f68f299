#include "calib/opencv_yaml.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "io/read_file.h"

namespace kappamu::calib {
namespace {

/// Shortest decimal that reads back as `value`.
std::string shortest(double value) {
  std::array<char, 40> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  std::string result(text.data(), end);
  // Without a point OpenCV takes it for an integer.
  if (result.find_first_of(".en") == std::string::npos) result += '.';
  return result;
}

/// Reads a text from front to back; each member says whether what it wants came next, and where it
/// did not, stays.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  bool at_end() const { return at_ == text_.size(); }
  std::size_t line() const {
    return 1 + static_cast<std::size_t>(std::count(text_.begin(), text_.begin() + at_, '\n'));
  }

  /// To the next line that is neither empty nor a comment.
  void next_line() {
    while (!at_end()) {
      const std::string_view line = peek_line();
      const std::size_t first = line.find_first_not_of(" \t\r");
      if (first != std::string_view::npos && line[first] != '#') return;
      skip_line();
    }
  }
  std::string_view peek_line() const { return text_.substr(at_, text_.find('\n', at_) - at_); }
  void skip_line() { at_ = std::min(text_.size(), at_ + peek_line().size() + 1); }

  bool word(std::string_view expected) {
    const std::size_t begin = after_space();
    if (!text_.substr(begin).starts_with(expected)) return false;
    at_ = begin + expected.size();
    return true;
  }

  template <class Number>
  bool number(Number& value) {
    const char* const begin = text_.data() + after_space();
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
    if (error != std::errc()) return false;
    at_ = static_cast<std::size_t>(end - text_.data());
    return true;
  }

 private:
  std::size_t after_space() const {
    return std::min(text_.size(), text_.find_first_not_of(" \t\r\n", at_));
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

/// "[ number, number ]" after "data:".
bool scan_numbers(Scanner& scanner, std::vector<double>& values) {
  if (!scanner.word("[")) return false;
  if (scanner.word("]")) return true;
  do {
    if (!scanner.number(values.emplace_back()) || !std::isfinite(values.back())) return false;
  } while (scanner.word(","));
  return scanner.word("]");
}

/// "dt: d" or "dt: \"2f\"", which ROS leaves out: how many numbers an element has.
bool scan_type(Scanner& scanner, int& channels) {
  channels = 1;
  if (!scanner.word("dt:")) return true;
  const bool quoted = scanner.word("\"");
  scanner.number(channels);
  for (const char* type : {"d", "f", "i", "u", "s", "w", "c"}) {
    if (scanner.word(type)) return channels > 0 && (!quoted || scanner.word("\""));
  }
  return false;
}

/// What follows "!!opencv-matrix".
bool scan_matrix(Scanner& scanner, int& rows, int& columns, std::vector<double>& values) {
  int channels = 1;
  if (!scanner.word("rows:") || !scanner.number(rows) || !scanner.word("cols:") ||
      !scanner.number(columns) || !scan_type(scanner, channels) || !scanner.word("data:") ||
      !scan_numbers(scanner, values) || rows < 0 || columns < 0) {
    return false;
  }
  const double count = static_cast<double>(rows) * columns * channels;
  columns = channels > 1 ? static_cast<int>(values.size()) / std::max(rows, 1) : columns;
  return count == static_cast<double>(values.size());
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Within quotes a backslash stands before a quote or another.
bool unquote(std::string_view quoted, std::string& text) {
  if (quoted.size() < 2 || quoted.back() != '"') return false;
  const std::string_view within = quoted.substr(1, quoted.size() - 2);
  for (std::size_t k = 0; k < within.size(); ++k) {
    if (within[k] == '"') return false;
    if (within[k] == '\\' && ++k == within.size()) return false;
    text += within[k];
  }
  return true;
}

}  // namespace

void YamlWriter::number(const std::string& key, double value) {
  text_ += key + ": " + shortest(value) + '\n';
}

void YamlWriter::text(const std::string& key, const std::string& value) {
  text_ += key + ": \"";
  for (const char letter : value) {
    if (letter == '"' || letter == '\\') text_ += '\\';
    text_ += letter;
  }
  text_ += "\"\n";
}

void YamlWriter::matrix(const std::string& key, int rows, int columns,
                        const std::vector<double>& values) {
  check(values.size() == static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns),
        "a matrix has rows * columns numbers");
  text_ += key + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
           "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [";
  constexpr std::size_t per_line = 4;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (k > 0) text_ += ',';
    text_ += k % per_line == 0 && k > 0 ? "\n       " : " ";
    text_ += shortest(values[k]);
  }
  text_ += " ]\n";
}

InputError YamlReader::bad(const std::string& reason) const {
  return InputError(file_.string() + ": " + reason + "; " + remedy_);
}

YamlReader::YamlReader(const std::filesystem::path& file, std::string remedy)
    : file_(file), remedy_(std::move(remedy)) {
  constexpr std::size_t most_bytes = 100'000'000;
  const std::string text = io::read_text(file, most_bytes);
  Scanner scanner(text);
  const auto damaged = [&] {
    return bad("line " + std::to_string(scanner.line()) +
               " is damaged or not as OpenCV writes YAML");
  };
  for (scanner.next_line(); !scanner.at_end(); scanner.next_line()) {
    const std::string_view line = scanner.peek_line();
    if (fields_.empty() && (line.starts_with('%') || line.starts_with("---"))) {
      scanner.skip_line();
      continue;
    }
    if (trimmed(line) == "...") break;
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos || colon == 0 || line.front() == ' ') throw damaged();
    const auto [place, is_new] = fields_.try_emplace(std::string(line.substr(0, colon)));
    if (!is_new) throw damaged();
    Field& field = place->second;
    const std::string_view value = trimmed(line.substr(colon + 1));
    if (value == "!!opencv-matrix" || value.empty()) {
      scanner.skip_line();
      field.is_matrix = true;
      if (!scan_matrix(scanner, field.rows, field.columns, field.values)) throw damaged();
      if (!trimmed(scanner.peek_line()).empty()) throw damaged();
    } else if (value.starts_with('"')) {
      field.quoted = true;
      if (!unquote(value, field.text)) throw damaged();
    } else {
      field.text = value;
    }
    scanner.skip_line();
  }
}

const YamlReader::Field& YamlReader::field(const std::string& key) const {
  const auto found = fields_.find(key);
  if (found == fields_.end()) throw bad("field " + key + " is missing");
  return found->second;
}

std::vector<double> YamlReader::numbers(const std::string& key) const {
  const auto found = fields_.find(key);
  if (found == fields_.end()) return {};
  if (found->second.is_matrix) return found->second.values;
  double value = 0.0;
  number(key, value);
  return {value};
}

void YamlReader::number(const std::string& key, double& value) const {
  const Field& scalar = field(key);
  Scanner scanner(scalar.text);
  if (scalar.is_matrix || scalar.quoted || !scanner.number(value) || !scanner.at_end() ||
      !std::isfinite(value)) {
    throw bad("field " + key + " is not a number");
  }
}

void YamlReader::text(const std::string& key, std::string& value) const {
  const Field& scalar = field(key);
  if (scalar.is_matrix) throw bad("field " + key + " is not a text");
  value = scalar.text;
}

void YamlReader::matrix(const std::string& key, int rows, int columns,
                        std::vector<double>& values) const {
  const Field& m = field(key);
  if (!m.is_matrix) throw bad("field " + key + " is not a matrix");
  if (m.rows != rows || m.columns != columns) {
    throw bad("field " + key + " is " + std::to_string(m.rows) + " x " + std::to_string(m.columns) +
              " instead of " + std::to_string(rows) + " x " + std::to_string(columns));
  }
  values = m.values;
}

void YamlReader::column(const std::string& key, std::vector<double>& values) const {
  matrix(key, field(key).rows, 1, values);
}

void YamlReader::require_whole(const std::string& key, double value, double low, double end) const {
  if (value >= low && value < end && value == std::floor(value)) return;
  throw bad("field " + key + " holds " + shortest(value) + " for a whole number");
}

}  // namespace kappamu::calib
