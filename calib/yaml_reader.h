// Reads OpenCV's YAML; a missing or misshapen field is an InputError naming file and field.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace kappamu::calib {

class YamlReader {
 public:
  explicit YamlReader(const std::filesystem::path& file);
  ~YamlReader();
  YamlReader(const YamlReader&) = delete;
  YamlReader& operator=(const YamlReader&) = delete;

  double number(const std::string& key) const;
  std::string text(const std::string& key) const;
  /// Row-major.
  std::vector<double> matrix(const std::string& key, int rows, int columns) const;
  /// A matrix of one column and any number of rows.
  std::vector<double> column(const std::string& key) const;

 private:
  struct Storage;
  std::filesystem::path file_;
  std::unique_ptr<Storage> storage_;
};

}  // namespace kappamu::calib
