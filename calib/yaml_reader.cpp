#include "calib/yaml_reader.h"

#include <opencv2/core.hpp>

#include "core/error.h"

namespace kappamu::calib {
namespace {

InputError bad(const std::filesystem::path& file, const std::string& reason) {
  return InputError(file.string() + ": " + reason + "; calibrate the session again");
}

}  // namespace

struct YamlReader::Storage {
  cv::FileStorage file;

  cv::FileNode at(const std::string& key, const std::filesystem::path& name) const {
    const cv::FileNode node = file[key];
    if (node.empty()) throw bad(name, "field " + key + " is missing");
    return node;
  }

  cv::Mat matrix(const std::string& key, const std::filesystem::path& name) const {
    const cv::FileNode node = at(key, name);
    cv::Mat result;
    try {
      // OpenCV makes room for what rows and cols say before it looks at the data.
      const double numbers = node.isMap() ? node["rows"].real() * node["cols"].real() : -1.0;
      if (numbers != static_cast<double>(node["data"].size())) throw cv::Exception();
      node >> result;
    } catch (const cv::Exception&) {
      throw bad(name, "field " + key + " is not a matrix");
    }
    if (result.type() != CV_64F) throw bad(name, "field " + key + " is not a matrix of doubles");
    return result;
  }
};

YamlReader::YamlReader(const std::filesystem::path& file)
    : file_(file), storage_(std::make_unique<Storage>()) {
  if (!std::filesystem::exists(file)) throw bad(file, "the file is missing");
  constexpr std::uintmax_t most_bytes = 100'000'000;
  if (std::filesystem::file_size(file) > most_bytes) {
    throw bad(file, "the file has more than 100 MB, which is no calibration");
  }
  bool open = false;
  try {
    open = storage_->file.open(file.string(), cv::FileStorage::READ);
  } catch (const cv::Exception&) {
    open = false;
  }
  if (!open) throw bad(file, "the file is damaged or no OpenCV YAML");
}

YamlReader::~YamlReader() = default;

double YamlReader::number(const std::string& key) const {
  const cv::FileNode node = storage_->at(key, file_);
  if (!node.isReal() && !node.isInt()) throw bad(file_, "field " + key + " is not a number");
  return node.real();
}

std::string YamlReader::text(const std::string& key) const {
  const cv::FileNode node = storage_->at(key, file_);
  if (!node.isString()) throw bad(file_, "field " + key + " is not a text");
  return node.string();
}

std::vector<double> YamlReader::matrix(const std::string& key, int rows, int columns) const {
  const cv::Mat m = storage_->matrix(key, file_);
  if (m.rows != rows || m.cols != columns) {
    throw bad(file_, "field " + key + " is " + std::to_string(m.rows) + " x " +
                         std::to_string(m.cols) + " instead of " + std::to_string(rows) + " x " +
                         std::to_string(columns));
  }
  return {m.ptr<double>(), m.ptr<double>() + m.total()};
}

std::vector<double> YamlReader::column(const std::string& key) const {
  const cv::Mat m = storage_->matrix(key, file_);
  if (m.cols != 1) throw bad(file_, "field " + key + " is not a column");
  return {m.ptr<double>(), m.ptr<double>() + m.total()};
}

}  // namespace kappamu::calib
