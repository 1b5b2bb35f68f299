// Calibrations' YAML: what OpenCV writes is read, what we write OpenCV reads, the rest is refused
// by line.
#include "calib/opencv_yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <opencv2/core.hpp>

#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using ::testing::HasSubstr;

const std::vector<double> numbers{1.0,  -2.5e-7, 3.25,      1e300, 0.1,
                                  -0.0, 7.0,     1.0 / 3.0, 9.0,   1e-300};

TEST(OpencvYaml, WhatOpencvWritesIsRead) {
  const OwnFolder folder;
  const std::filesystem::path file = folder / "a.yml";
  {
    cv::FileStorage storage(file.string(), cv::FileStorage::WRITE);
    storage << "width" << 640 << "rms" << 0.125 << "model"
            << "brown5";
    storage << "name"
            << "a \"name\" of several: words";
    storage << "matrix" << cv::Mat(2, 5, CV_64F, const_cast<double*>(numbers.data()));
    storage << "none" << cv::Mat(0, 0, CV_64F) << "last" << 3;
  }
  const YamlReader yaml(file);
  double number = 0.0;
  yaml.number("width", number);
  EXPECT_EQ(number, 640.0);
  yaml.number("rms", number);
  EXPECT_EQ(number, 0.125);
  std::string text;
  yaml.text("model", text);
  EXPECT_EQ(text, "brown5");
  yaml.text("name", text);
  EXPECT_EQ(text, "a \"name\" of several: words");
  std::vector<double> values;
  yaml.matrix("matrix", 2, 5, values);
  for (std::size_t k = 0; k < numbers.size(); ++k) EXPECT_DOUBLE_EQ(values[k], numbers[k]);
  yaml.matrix("none", 0, 0, values);
  EXPECT_TRUE(values.empty());
  yaml.number("last", number);
  EXPECT_EQ(number, 3.0);
}

TEST(OpencvYaml, WhatWeWriteOpencvReads) {
  const OwnFolder folder;
  const std::filesystem::path file = folder / "a.yml";
  YamlWriter ours;
  ours.number("rms", 1.0 / 3.0);
  ours.text("name", R"(a "name" \ of several: words)");
  ours.matrix("matrix", 5, 2, numbers);
  std::ofstream(file) << ours.str();

  const YamlReader back(file);
  std::vector<double> values;
  back.matrix("matrix", 5, 2, values);
  EXPECT_EQ(values, numbers);

  const cv::FileStorage storage(file.string(), cv::FileStorage::READ);
  EXPECT_EQ(storage["rms"].real(), 1.0 / 3.0);
  EXPECT_EQ(storage["name"].string(), R"(a "name" \ of several: words)");
  cv::Mat matrix;
  storage["matrix"] >> matrix;
  EXPECT_EQ(std::vector<double>(matrix.begin<double>(), matrix.end<double>()), numbers);
}

TEST(OpencvYaml, WhatIsNeitherIsRefusedByLine) {
  const OwnFolder folder;
  const std::filesystem::path file = folder / "a.yml";
  const std::string matrix = "m: !!opencv-matrix\n   rows: 1\n   cols: 2\n   dt: d\n";
  for (const auto& [text, expected] :
       {std::pair<std::string, const char*>{"just words\n", "line 3 is damaged"},
        {"a: 1\na: 2\n", "line 4 is damaged"},
        {"  a: 1\n", "line 3 is damaged"},
        {"a: 1\n---\nb: 1\n", "line 4 is damaged"},
        {"a: \"open\n", "line 3 is damaged"},
        {"a: \"open\\\"\n", "line 3 is damaged"},
        {matrix, "line 6 is damaged"},
        {matrix + "   data: [ 1., 2.", "line 7 is damaged"},
        {matrix + "   data: [ 1., 2., 3. ]\n", "line 7 is damaged"},
        {matrix + "   data: [ 1., inf ]\n", "line 7 is damaged"},
        {matrix + "   data: [ 1., 2. ] more\n", "line 7 is damaged"}}) {
    std::ofstream(file) << "%YAML:1.0\n---\n" << text;
    const std::string sentence = sentence_of([&] { const YamlReader yaml(file); });
    EXPECT_THAT(sentence, HasSubstr(file.string() + ": " + expected)) << text;
  }
}

TEST(OpencvYaml, FieldsOfAnotherKindAreNamed) {
  const OwnFolder folder;
  const std::filesystem::path file = folder / "a.yml";
  std::ofstream(file)
      << "%YAML:1.0\n---\n# a comment\nword: hello\nquoted: \"1\"\nwide: !!opencv-matrix\n"
         "   rows: 1\n   cols: 2\n   dt: d\n   data: [ 1., 2. ]\n";
  const YamlReader yaml(file);
  double number = 0.0;
  std::string text;
  std::vector<double> values;
  for (const auto& [act, expected] :
       {std::pair<std::function<void()>, const char*>{[&] { yaml.number("word", number); },
                                                      "word is not a number"},
        {[&] { yaml.number("quoted", number); }, "quoted is not a number"},
        {[&] { yaml.number("wide", number); }, "wide is not a number"},
        {[&] { yaml.number("nothing", number); }, "nothing is missing"},
        {[&] { yaml.text("wide", text); }, "wide is not a text"},
        {[&] { yaml.column("word", values); }, "word is not a matrix"},
        {[&] { yaml.column("wide", values); }, "wide is 1 x 2 instead of 1 x 1"}}) {
    EXPECT_THAT(sentence_of(act), HasSubstr(expected));
  }
}

}  // namespace
}  // namespace kappamu::calib
