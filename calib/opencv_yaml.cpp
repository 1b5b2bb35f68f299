#include "calib/opencv_yaml.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <new>
#include <opencv2/core.hpp>

#include "core/error.h"

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

InputError bad(const std::filesystem::path& file, const std::string& reason) {
  return InputError(file.string() + ": " + reason + "; calibrate the session again");
}

cv::FileNode node_of(const cv::FileStorage& storage, const std::string& key,
                     const std::filesystem::path& file) {
  cv::FileNode node;
  try {
    node = storage[key];
  } catch (const cv::Exception&) {  // a list, or nothing, where fields were expected
    throw bad(file, "the file is damaged or no OpenCV YAML");
  }
  if (node.empty()) throw bad(file, "field " + key + " is missing");
  return node;
}

cv::Mat matrix_of(const cv::FileStorage& storage, const std::string& key,
                  const std::filesystem::path& file) {
  const cv::FileNode node = node_of(storage, key, file);
  cv::Mat result;
  try {
    // OpenCV makes room for what rows and cols say before it looks at the data.
    const double numbers = node.isMap() ? node["rows"].real() * node["cols"].real() : -1.0;
    if (numbers != static_cast<double>(node["data"].size())) throw cv::Exception();
    node >> result;
  } catch (const cv::Exception&) {
    throw bad(file, "field " + key + " is not a matrix");
  }
  if (result.type() != CV_64F) throw bad(file, "field " + key + " is not a matrix of doubles");
  return result;
}

/// Whether there is one document and its first field is not indented. Where it is and a later line
/// is less so, OpenCV's parser (4.6) never ends.
bool begins_at_the_margin(const std::filesystem::path& file) {
  std::ifstream text(file, std::ios::binary);
  int documents = 0;
  bool within = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("---") && ++documents > 1) return false;
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (line.starts_with("---") || line.starts_with("...") || line.starts_with('%')) {
      within = false;
    } else if (first != std::string::npos && line[first] != '#' && line[first] != '%') {
      if (!within && first > 0) return false;
      within = true;
    }
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

YamlReader::YamlReader(const std::filesystem::path& file)
    : file_(file), storage_(std::make_shared<cv::FileStorage>()) {
  if (!std::filesystem::exists(file)) throw bad(file, "the file is missing");
  constexpr std::uintmax_t most_bytes = 100'000'000;
  if (std::filesystem::file_size(file) > most_bytes) {
    throw bad(file, "the file has more than 100 MB, which is no calibration");
  }
  if (!begins_at_the_margin(file)) throw bad(file, "the file is damaged or no OpenCV YAML");
  bool open = false;
  try {
    open = storage_->open(file.string(), cv::FileStorage::READ);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {  // cv::Exception, and std::length_error of its parser
    open = false;
  }
  if (!open) throw bad(file, "the file is damaged or no OpenCV YAML");
}

void YamlReader::number(const std::string& key, double& value) const {
  const cv::FileNode node = node_of(*storage_, key, file_);
  if (!node.isReal() && !node.isInt()) throw bad(file_, "field " + key + " is not a number");
  value = node.real();
}

void YamlReader::text(const std::string& key, std::string& value) const {
  const cv::FileNode node = node_of(*storage_, key, file_);
  if (!node.isString()) throw bad(file_, "field " + key + " is not a text");
  value = node.string();
}

void YamlReader::matrix(const std::string& key, int rows, int columns,
                        std::vector<double>& values) const {
  const cv::Mat m = matrix_of(*storage_, key, file_);
  if (m.rows != rows || m.cols != columns) {
    throw bad(file_, "field " + key + " is " + std::to_string(m.rows) + " x " +
                         std::to_string(m.cols) + " instead of " + std::to_string(rows) + " x " +
                         std::to_string(columns));
  }
  values.assign(m.ptr<double>(), m.ptr<double>() + m.total());
}

void YamlReader::column(const std::string& key, std::vector<double>& values) const {
  const cv::Mat m = matrix_of(*storage_, key, file_);
  if (m.cols != 1) throw bad(file_, "field " + key + " is not a column");
  values.assign(m.ptr<double>(), m.ptr<double>() + m.total());
}

void YamlReader::require_whole(const std::string& key, double value, double low, double end) const {
  if (value >= low && value < end && value == std::floor(value)) return;
  throw bad(file_, "field " + key + " holds " + shortest(value) + " for a whole number");
}

}  // namespace kappamu::calib
