#include "calib/yaml_writer.h"

#include <array>
#include <charconv>

#include "core/error.h"

namespace kappamu::calib {

std::string shortest(double value) {
  std::array<char, 40> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  std::string result(text.data(), end);
  // Without a point OpenCV takes it for an integer.
  if (result.find_first_of(".en") == std::string::npos) result += '.';
  return result;
}

void YamlWriter::number(const std::string& key, double value) {
  text_ += key + ": " + shortest(value) + '\n';
}

void YamlWriter::text(const std::string& key, const std::string& value) {
  std::string escaped;
  for (const char letter : value) {
    if (letter == '"' || letter == '\\') escaped += '\\';
    escaped += letter;
  }
  text_ += key;
  text_ += ": \"";
  text_ += escaped;
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

}  // namespace kappamu::calib
