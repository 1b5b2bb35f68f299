// OpenCV's YAML, written with as many digits as a double needs to come back unchanged (OpenCV's own
// writer keeps 16).
#pragma once

#include <string>
#include <vector>

namespace kappamu::calib {

class YamlWriter {
 public:
  void number(const std::string& key, double value);
  void text(const std::string& key, const std::string& value);
  /// Row-major, rows * columns numbers.
  void matrix(const std::string& key, int rows, int columns, const std::vector<double>& values);

  const std::string& str() const { return text_; }

 private:
  std::string text_ = "%YAML:1.0\n---\n";
};

/// Shortest decimal that reads back as `value`.
std::string shortest(double value);

}  // namespace kappamu::calib
