// A temporary folder per test, records measured into it, and their charts.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "studies/subject.h"
#include "tests/own_folder.h"

namespace kappamu::studies {

class FolderTest : public testing::Test {
 protected:
  const std::filesystem::path& folder() const { return folder_; }

 private:
  const OwnFolder folder_;
};

class RecordTest : public FolderTest {
 protected:
  /// Measures one section in its quick form.
  Json quick_record(const std::string& subject_name, const std::string& section,
                    Request request = {}) const {
    request.folder = folder();
    request.size = Size::quick;
    Progress silent;
    return measure(subject(subject_name), {section}, request, silent).at(0);
  }

  /// Draws the folder and expects these pictures and tables; the last table's text. Nothing where
  /// matplotlib is not installed.
  std::string expect_charts(const std::vector<std::string>& pictures,
                            const std::vector<std::string>& tables) const {
    if (std::system("/usr/bin/python3 -c 'import matplotlib' 2>/dev/null") != 0) {
      ADD_FAILURE() << "install the Debian package python3-matplotlib";
      return "";
    }
    const std::string script = KAPPAMU_SOURCE_DIR "/studies/bench_charts.py";
    EXPECT_EQ(std::system(("/usr/bin/python3 " + script + " '" + folder().string() + "'").c_str()),
              0);
    for (const std::string& name : pictures) {
      // An empty page of axes is a fifth of this.
      EXPECT_GT(std::filesystem::file_size(folder() / (name + ".png")), 5000U) << name;
    }
    std::string text;
    for (const std::string& name : tables) {
      std::ifstream file(folder() / (name + ".md"));
      text.assign(std::istreambuf_iterator<char>(file), {});
      EXPECT_NE(text.find("|---|"), std::string::npos) << name;
    }
    return text;
  }
};

}  // namespace kappamu::studies
