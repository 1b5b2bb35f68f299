// The part of OpenCV's YAML that calibrations need: numbers, texts and matrices of doubles, by key
// at the margin. Writer and reader have the same members, so that one function describes what a
// file holds for both: the writer leaves the values it is given as they are, the reader sets them.
#pragma once

#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "core/error.h"

namespace kappamu::calib {

/// With as many digits as a double needs to come back unchanged (OpenCV's own writer keeps 16).
class YamlWriter {
 public:
  void number(const std::string& key, double value);
  void text(const std::string& key, const std::string& value);
  /// Row-major, rows * columns numbers.
  void matrix(const std::string& key, int rows, int columns, const std::vector<double>& values);
  void column(const std::string& key, const std::vector<double>& values) {
    matrix(key, static_cast<int>(values.size()), 1, values);
  }

  template <class Number>
  Number number_as(const std::string& /*key*/, double value, Number /*low*/ = {},
                   Number /*high*/ = {}) const {
    return static_cast<Number>(value);
  }

  const std::string& str() const { return text_; }

 private:
  std::string text_ = "%YAML:1.0\n---\n";
};

/// Reads what YamlWriter and OpenCV's own writer make of such values, matrices of any type and
/// number of channels included, and ROS's matrices, which lack OpenCV's tag. (OpenCV's reader loops
/// forever on some damaged files.) Each member throws InputError naming file and field where it is
/// missing or misshapen; the constructor, file and line.
class YamlReader {
 public:
  /// `remedy` ends the sentences.
  explicit YamlReader(const std::filesystem::path& file,
                      std::string remedy = "calibrate the session again");

  bool has(const std::string& key) const { return fields_.count(key) != 0; }
  /// Of a matrix of any shape or a single number; empty where the field is missing.
  std::vector<double> numbers(const std::string& key) const;
  void number(const std::string& key, double& value) const;
  void text(const std::string& key, std::string& value) const;
  void matrix(const std::string& key, int rows, int columns, std::vector<double>& values) const;
  /// A matrix of one column and any number of rows.
  void column(const std::string& key, std::vector<double>& values) const;
  /// A number of the field as an int, std::size_t or bool (0 or 1) from low to high, or a double.
  template <class Number>
  Number number_as(const std::string& key, double value,
                   Number low = std::numeric_limits<Number>::lowest(),
                   Number high = std::numeric_limits<Number>::max()) const {
    if constexpr (std::is_integral_v<Number>) {
      require_whole(key, value, static_cast<double>(low), static_cast<double>(high) + 1.0);
    }
    return static_cast<Number>(value);
  }

 private:
  struct Field {
    std::string text;     ///< of a scalar, without quotes
    bool quoted = false;  ///< and therefore no number
    bool is_matrix = false;
    int rows = 0;
    int columns = 0;
    std::vector<double> values;  ///< [row][column]
  };

  const Field& field(const std::string& key) const;
  void require_whole(const std::string& key, double value, double low, double end) const;

  InputError bad(const std::string& reason) const;

  std::filesystem::path file_;
  std::string remedy_;
  std::map<std::string, Field> fields_;
};

}  // namespace kappamu::calib
