// `kappamu-studies forward --quick`, section by section: it runs, its record and summary are whole,
// its charts can be drawn. Numbers on toy grids mean nothing.
#include "studies/forward/forward_bench.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/image/image_file.h"
#include "studies/forward/comparison.h"
#include "studies/forward/kernels.h"
#include "tests/studies/bench_tools.h"

namespace kappamu::studies {

namespace {

class ForwardBenchTest : public RecordTest {
 protected:
  Json measure(const std::string& section) {
    Request request;
    request.settings["repetitions"] = {"1"};
    return quick_record("forward", section, request);
  }

  static void expect_header(const Json& record) {
    EXPECT_FALSE(record.at("machine").at("cpu").get<std::string>().empty());
    EXPECT_GT(record.at("machine").at("cores").get<int>(), 0);
    EXPECT_GT(record.at("machine").at("memory_bytes").get<double>(), 1e8);
    EXPECT_GT(record.at("machine").at("copy_bandwidth_bytes_per_second").get<double>(), 1e8);
    EXPECT_FALSE(record.at("device").get<std::string>().empty());
    EXPECT_FALSE(record.at("program").at("kappamu").get<std::string>().empty());
    EXPECT_EQ(record.at("size"), "quick");
  }
};

TEST_F(ForwardBenchTest, HeadlineHoldsEveryMethod) {
  const Json record = measure("headline");
  expect_header(record);
  expect_charts({"forward-headline"}, {"forward-headline"});
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
  expect_charts({"forward-peers"}, {"forward-peers"});
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

TEST_F(ForwardBenchTest, KernelsOfTheFinestGridAreTimedWithTheirBytes) {
  const Json record = measure("kernels");
  expect_header(record);
  const Json& run = record.at("runs").at(0);
  ASSERT_EQ(run.at("profiles").size(), 2U);
  for (const Json& profile : run.at("profiles")) {
    const double iterations = profile.at("iterations").get<double>();
    double seconds = profile.at("coarse_seconds").get<double>();
    int in_every_iteration = 0;
    for (const Json& use : profile.at("kernels")) {
      const auto name = use.at("kernel").get<std::string>();
      // A kernel without its bytes leaves a hole in the table: state them in
      // studies/forward/kernels.cpp.
      EXPECT_TRUE(use.contains("bytes_per_launch")) << name;
      EXPECT_GT(use.at("seconds_per_launch").get<double>(), 0.0) << name;
      in_every_iteration += use.at("launches_per_solve").get<double>() == iterations ? 1 : 0;
      seconds += use.at("seconds_per_solve").get<double>();
    }
    // Down, up and step; on GPUs there are more.
    EXPECT_GE(in_every_iteration, 3);
    EXPECT_LT(seconds, profile.at("solve_seconds").get<double>());
    EXPECT_GT(profile.at("finest_bandwidth_fraction").get<double>(), 0.0);
  }
  const std::string text = expect_charts({}, {"forward-kernels"});
  EXPECT_THAT(text, testing::HasSubstr("of copy bandwidth |"));
  EXPECT_THAT(text, testing::HasSubstr("contrast 10 with inclusions ×100 and ÷100"));
  const Json summary = forward_summary(folder());
  EXPECT_EQ(summary.at("sections"), Json({"kernels"}));
  EXPECT_EQ(summary.at("kernels").size(), 2U);
}

TEST(KernelBytes, AnIterationMovesWhatTheWholeSolveCounts) {
  // docs/engine.md: 0.60 GB an iteration on 256x256x20, 16 patterns in float, of which the finest
  // grid's three sweeps are all but the coarser grids' 3 N/7 vectors and 16 N/7 coefficients, N
  // cells; down and up share 2 N/8 vectors of the next grid.
  const std::size_t cells = 256 * 256 * 20;
  double finest = 0.0;
  for (const char* kernel : {"stream_down", "stream_up", "stream_step"}) {
    finest += kernel_bytes(kernel, cells, cells / 8, 16, sizeof(float)).value();
  }
  const double n = static_cast<double>(cells) * sizeof(float);
  const double below = n * (5.0 / 7.0 - 2.0 / 8.0) * 16 + n * 16.0 / 7.0;
  EXPECT_NEAR(finest + below, 16 * least_bytes(cells, 16, 1, sizeof(float)), 1e-9 * finest);
  EXPECT_NEAR(finest + below, 0.60e9, 0.005e9);
  EXPECT_FALSE(kernel_bytes("no such kernel", cells, cells / 8, 16, sizeof(float)));
}

TEST_F(ForwardBenchTest, SummaryNamesTheFastestPeerAndWhatRelaxationTakes) {
  // Made-up records: what is tested is the arithmetic of the claims.
  const auto sample = [](const char* method, const char* precision, double seconds, double error) {
    Sample s;
    s.method = method;
    s.precision = precision;
    s.patterns = 16;
    s.solve_seconds_per_rhs = s.seconds_per_rhs = seconds;
    s.phi_error = error;
    return s;
  };
  constexpr double copy_bandwidth = 1e10;
  const auto write = [&](const std::string& section, const std::vector<Sample>& samples) {
    Json record = record_header("forward", "none");
    record["runs"] = Json::array({{{"problem",
                                    {{"grid", {8, 8, 8}},
                                     {"patterns", 16},
                                     {"contrast", 10.0},
                                     {"background_contrast", 1.0}}},
                                   {"comparison", compare(samples, 512, copy_bandwidth)},
                                   {"relaxation", compare_relaxation(samples)}}});
    write_record(record, folder() / ("forward-" + section + ".json"));
  };
  write("peers",
        {sample("multigrid", "single", 0.03, 1e-7), sample("hypre-pfmg", "double", 0.33, 1e-7),
         sample("hypre-other", "double", 0.24, 1e-7), sample("hypre-third", "double", 0.20, 1e-4)});
  write("headline",
        {sample("multigrid", "single", 0.01, 1e-3), sample("relaxation", "single", 3.0, 0.2),
         sample("gauss-seidel", "single", 2.0, 1e-3)});
  const Json summary = forward_summary(folder());
  EXPECT_EQ(summary.at("fastest_peer"), "hypre-other") << "the other never reached the error";
  EXPECT_NEAR(summary.at("fastest_peer_ratio").get<double>(), 8.0, 1e-9);
  const Json& relaxation = summary.at("relaxation");
  ASSERT_EQ(relaxation.size(), 2U);
  EXPECT_TRUE(relaxation[0].at("ratio_is_lower_bound").get<bool>());
  EXPECT_NEAR(relaxation[0].at("ratio").get<double>(), 300.0, 1e-9);
  EXPECT_FALSE(relaxation[1].at("ratio_is_lower_bound").get<bool>());
  EXPECT_NEAR(relaxation[1].at("ratio").get<double>(), 200.0, 1e-9);
}

TEST_F(ForwardBenchTest, OtherSectionsDrawTheirPictures) {
  std::vector<std::string> names;
  for (const char* section : {"grids", "scaling"}) {
    expect_header(measure(section));
    names.push_back("forward-" + std::string(section));
  }
  expect_charts(names, names);
}

TEST_F(ForwardBenchTest, UnknownSectionIsRefusedWithTheNames) {
  EXPECT_THAT([&] { measure("speed"); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("choose one of headline")));
}

TEST_F(ForwardBenchTest, SummaryOfAnEmptyFolderNamesWhatToMeasure) {
  EXPECT_THAT([&] { forward_summary(folder()); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("measure section peers")));
}

TEST_F(ForwardBenchTest, DamagedRecordIsRefused) {
  std::ofstream(folder() / "forward-headline.json") << "{}";
  EXPECT_THAT([&] { forward_summary(folder()); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("measure again")));
}

}  // namespace
}  // namespace kappamu::studies
