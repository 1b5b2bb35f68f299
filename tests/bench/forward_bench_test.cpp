// `kappamu bench forward --quick`, section by section: it runs, its record and summary are whole,
// its pictures show something. What the numbers say on toy grids is nothing.
#include "bench/forward_bench.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "bench/record.h"
#include "core/error.h"
#include "tests/bench/bench_tools.h"

namespace kappamu::bench {

namespace {

using Json = nlohmann::ordered_json;

class ForwardBenchTest : public FolderTest {
 protected:
  Json measure(const std::string& section) {
    Progress progress;
    ForwardBenchOptions options;
    options.folder = folder();
    options.quick = true;
    options.repetitions = 1;
    measure_forward(section, options, progress);
    draw_forward(folder());
    return read_record(folder() / ("forward-" + section + ".json"), "forward-" + section);
  }

  void expect_picture(const std::string& section) const {
    const cv::Mat picture = cv::imread((folder() / ("bench-" + section + ".png")).string());
    ASSERT_GT(picture.total(), 0U) << section;
    int inked = 0;
    for (int y = 0; y < picture.rows; ++y) {
      for (int x = 0; x < picture.cols; ++x) {
        inked += picture.at<cv::Vec3b>(y, x) != cv::Vec3b(255, 255, 255) ? 1 : 0;
      }
    }
    EXPECT_GT(inked, picture.rows * picture.cols / 100) << section;
    std::ifstream table(folder() / ("table-" + section + ".md"));
    std::ostringstream text;
    text << table.rdbuf();
    EXPECT_THAT(text.str(), testing::HasSubstr("|---|"));
  }

  static void expect_header(const Json& record) {
    EXPECT_FALSE(record.at("machine").at("cpu").get<std::string>().empty());
    EXPECT_GT(record.at("machine").at("cores").get<int>(), 0);
    EXPECT_GT(record.at("machine").at("memory_bytes").get<double>(), 1e8);
    EXPECT_GT(record.at("machine").at("copy_bandwidth_bytes_per_second").get<double>(), 1e8);
    EXPECT_FALSE(record.at("device").get<std::string>().empty());
    EXPECT_FALSE(record.at("program").at("kappamu").get<std::string>().empty());
    EXPECT_TRUE(record.at("quick").get<bool>());
  }
};

TEST_F(ForwardBenchTest, HeadlineHoldsEveryMethod) {
  const Json record = measure("headline");
  expect_header(record);
  expect_picture("headline");
  std::vector<std::string> methods;
  for (const Json& sample : record.at("runs").at(0).at("samples")) {
    methods.push_back(sample.at("method").get<std::string>());
    EXPECT_GT(sample.at("seconds_per_rhs").get<double>(), 0.0);
    EXPECT_GT(sample.at("true_error").get<double>(), 0.0);
  }
  for (const char* method : {"multigrid", "reference", "relaxation", "hierarchical", "adaptive"}) {
    EXPECT_THAT(methods, testing::Contains(method));
  }
}

TEST_F(ForwardBenchTest, SummaryHasAllFields) {
  measure("peers");
  expect_picture("peers");
  const Json summary = forward_summary(folder());
  for (const char* field :
       {"grid", "patterns", "contrast", "method", "precision", "iterations", "seconds_per_rhs",
        "true_error", "bandwidth_fraction", "target_error", "single_precision_floor", "peers"}) {
    EXPECT_TRUE(summary.contains(field)) << field;
  }
  EXPECT_LE(summary.at("true_error").get<double>(), summary.at("target_error").get<double>());
  EXPECT_GT(summary.at("bandwidth_fraction").get<double>(), 0.0);
  for (const Json& peer : summary.at("peers")) {
    EXPECT_GT(peer.at("ratio").get<double>(), 0.0);
    EXPECT_LE(peer.at("true_error").get<double>(), summary.at("target_error").get<double>());
    for (const char* field : {"method", "precision", "iterations", "seconds_per_rhs", "setting"}) {
      EXPECT_TRUE(peer.contains(field)) << field;
    }
  }
}

TEST_F(ForwardBenchTest, OtherSectionsDrawTheirPictures) {
  for (const char* section : {"relaxation", "grids", "scaling", "iterations"}) {
    expect_header(measure(section));
    expect_picture(section);
  }
}

TEST_F(ForwardBenchTest, UnknownSectionIsRefusedWithTheNames) {
  Progress progress;
  EXPECT_THAT([&] { measure_forward("speed", {folder()}, progress); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("choose one of headline")));
}

TEST_F(ForwardBenchTest, SummaryOfAnEmptyFolderSaysWhatToMeasure) {
  EXPECT_THAT([&] { forward_summary(folder()); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("measure section peers")));
}

TEST_F(ForwardBenchTest, DamagedRecordIsRefused) {
  std::ofstream(folder() / "forward-headline.json") << "{}";
  EXPECT_THAT([&] { draw_forward(folder()); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("measure again")));
}

}  // namespace
}  // namespace kappamu::bench
