// The measurements of `kappamu-studies inverse`: truths that are figures and not grids, scores that
// recognise the truth, records and their summaries.
#include "studies/inverse/inverse_bench.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "studies/inverse/inverse_fit.h"
#include "tests/cases/media.h"
#include "tests/studies/bench_tools.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

Medium medium_of(const GridShape& shape, const inverse::CoefficientPair& fields) {
  Medium medium{Volume<double>(shape), Volume<double>(shape)};
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    medium.kappa[i] = std::exp(fields.log_kappa[i]);
    medium.mu[i] = std::exp(fields.log_mu[i]);
  }
  return medium;
}

const GridShape shape{12, 10, 6, 0.5};

TEST(InverseTruth, HasTheContrastAskedForAndDiffersBySeed) {
  TruthSpec spec;
  spec.inclusions = false;
  const auto a = make_truth(shape, spec);
  const auto [low, high] = std::minmax_element(a.log_kappa.begin(), a.log_kappa.end());
  EXPECT_LT(*high - *low, std::log(spec.contrast) + 1e-9);
  EXPECT_GT(*high - *low, 0.6 * std::log(spec.contrast));
  spec.seed = 2;
  EXPECT_NE(a.log_kappa, make_truth(shape, spec).log_kappa);
}

TEST(InverseTruth, IsTheSameFigureOnAFinerGrid) {
  TruthSpec spec;
  spec.inclusions = false;
  const auto coarse = make_truth(shape, spec);
  const auto fine = make_truth(shape.refined(2), spec);
  // A cell's value against the mean of its children: second order in the voxel.
  constexpr double second_order = 0.02;
  for (int z = 0; z < shape.nz; ++z) {
    double mean = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      mean += 0.125 * fine.log_mu[shape.refined(2).index(8 + (corner & 1), 6 + (corner >> 1 & 1),
                                                         2 * z + (corner >> 2))];
    }
    EXPECT_NEAR(coarse.log_mu[shape.index(4, 3, z)], mean, second_order);
  }
}

TEST(InverseTruth, EmbeddedBoxesKeepAMillimetreToEveryFace) {
  const GridShape block{64, 64, 20, 0.25};
  TruthSpec spec;
  spec.embedded = true;
  for (const std::uint64_t seed : {1, 2, 3}) {
    spec.seed = seed;
    spec.inclusions = true;
    const auto boxes = make_truth(block, spec);
    spec.inclusions = false;
    const auto smooth = make_truth(block, spec);
    double volume = 0.0;
    for (int z = 0; z < block.nz; ++z) {
      for (int y = 0; y < block.ny; ++y) {
        for (int x = 0; x < block.nx; ++x) {
          const std::size_t i = block.index(x, y, z);
          const double step = smooth.log_kappa[i] - boxes.log_kappa[i];
          if (step == 0.0) continue;
          EXPECT_NEAR(step, std::log(3.0), 1e-12);
          volume += std::pow(block.voxel_mm, 3);
          for (const double to_face : {x + 0.5, block.nx - x - 0.5, y + 0.5, block.ny - y - 0.5,
                                       z + 0.5, block.nz - z - 0.5}) {
            EXPECT_GT(to_face * block.voxel_mm, 1.0);
          }
        }
      }
    }
    EXPECT_NEAR(volume, 3.0 * 3.0 * 1.5, 3.0) << "seed " << seed;  // a voxel at each end
  }
}

TEST(AppearanceError, OfTheTruthIsSmallAndOfAHomogeneousBlockIsNot) {
  Block block;
  block.grid = shape;
  TruthSpec spec;
  spec.inclusions = false;
  const auto fine = make_truth(shape.refined(2), spec);
  const Validation validation = make_validation(block, fine, 4);
  const double truth =
      appearance_error(medium_of(shape, make_truth(shape, spec)), validation.patches);
  const double homogeneous = appearance_error(
      {Volume<double>(shape, spec.kappa), Volume<double>(shape, spec.mu)}, validation.patches);
  EXPECT_LT(truth, 1e-3);
  EXPECT_GT(homogeneous, 10.0 * truth);
}

TEST(DepthErrorOf, AVolumeTenPercentOffIsTenPercentInEveryLayer) {
  TruthSpec spec;
  const auto fine = make_truth(shape.refined(2), spec);
  Medium medium{Volume<double>(shape), Volume<double>(shape)};
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        for (int corner = 0; corner < 8; ++corner) {
          const std::size_t from = shape.refined(2).index(
              2 * x + (corner & 1), 2 * y + (corner >> 1 & 1), 2 * z + (corner >> 2));
          const std::size_t i = shape.index(x, y, z);
          medium.kappa[i] += 1.1 / 8.0 * std::exp(fine.log_kappa[from]);
          medium.mu[i] += 0.9 / 8.0 * std::exp(fine.log_mu[from]);
        }
      }
    }
  }
  for (const Face lit : {Face::z_minus, Face::x_plus}) {
    const DepthError error = depth_error(medium, fine, lit);
    ASSERT_EQ(error.kappa.size(), static_cast<std::size_t>(shape.extent(axis_of(lit))));
    for (const double e : error.kappa) EXPECT_NEAR(e, 0.1, 1e-9);
    for (const double e : error.mu) EXPECT_NEAR(e, 0.1, 1e-9);
  }
}

TEST(BarLight, LightsEveryVoxelByOneBarEitherWay) {
  const FaceShape face = face_shape(shape, Face::z_minus);
  const auto [nu, nv] =
      std::pair(static_cast<std::size_t>(face.nu), static_cast<std::size_t>(face.nv));
  const std::size_t bars = 5;
  const std::vector<double> light = bar_light(shape, Face::z_minus, static_cast<int>(bars));
  ASSERT_EQ(light.size(), 2 * bars * face.cells());
  const auto value = [&](std::size_t pattern, std::size_t u, std::size_t v) {
    return light[pattern * face.cells() + v * nu + u];
  };
  for (std::size_t v = 0; v < nv; ++v) {
    for (std::size_t u = 0; u < nu; ++u) {
      double across_u = 0.0, across_v = 0.0;
      for (std::size_t bar = 0; bar < bars; ++bar) {
        across_u += value(bar, u, v);
        across_v += value(bars + bar, u, v);
        EXPECT_EQ(value(bar, u, v), value(bar, u, 0));
        EXPECT_EQ(value(bars + bar, u, v), value(bars + bar, 0, v));
      }
      EXPECT_EQ(across_u, 1.0);
      EXPECT_EQ(across_v, 1.0);
    }
  }
}

class InverseBench : public RecordTest {};

TEST_F(InverseBench, QuickOptimisersAreMeasuredDrawnAndSummedUp) {
  const Json record = quick_record("inverse", "optimisers");
  const std::string table = expect_charts({"inverse-optimisers"}, {"inverse-optimisers"});
  for (const Variant& variant : inverse_variants()) {
    EXPECT_THAT(table, testing::HasSubstr(variant.label));
  }
  const Json summary = inverse_summary({record}, folder());
  EXPECT_EQ(summary.at("patterns"), 16);
  EXPECT_GT(summary.at("batched_solves").get<int>(), 10);
  EXPECT_LT(summary.at("validation_E").get<double>(), 0.01);
  EXPECT_THROW(quick_record("inverse", "nothing"), InputError);
}

TEST_F(InverseBench, PaperSamplesKeepTheRowsOfOthersAndAreSummedUp) {
  for (const char* sample : {"stone", "wax2"}) {
    Request request;
    request.settings["sample"] = {sample};
    const Json record = quick_record("inverse", "samples", request);
    const Json summary = inverse_summary({record}, folder());
    EXPECT_EQ(summary.at("sample"), sample);
    EXPECT_EQ(summary.at("samples").size(), 1U);
    EXPECT_EQ(summary.at("validation_E").size(), 3U);
    for (const char* coverage : {"kappa_coverage", "mu_coverage"}) {
      EXPECT_EQ(record.at("rows").back().at(coverage).size(), 3U) << coverage;
    }
  }
  const std::string table = expect_charts({}, {"inverse-samples"});
  for (const char* row : {"| stone | 16 × 16 × 41 | 3 |", "| wax2 | 17 × 12 × 48 | 4 |"}) {
    EXPECT_THAT(table, testing::HasSubstr(row));
  }
}

// Rows of several truths and noises: the median truth at 1 % stands for all.
TEST_F(InverseBench, SummaryIsOfTheMedianTruthAtOnePercent) {
  const auto row = [](const char* light, double noise, double error) {
    return Json{{"variant", light}, {"grid", {8, 8, 4}},       {"patterns", 16},
                {"noise", noise},   {"device", "none"},        {"batched_solves", 100},
                {"seconds", 1.0},   {"data_misfit_chi2", 1.0}, {"validation_E", error}};
  };
  const Json scores{{"section", "scores"},
                    {"rows",
                     {row("bars", 0.01, 3e-4), row("bars", 0.03, 9e-4), row("patches", 0.01, 8e-4),
                      row("bars", 0.01, 1e-4), row("bars", 0.01, 2e-4)}}};
  const Json losses{{"section", "losses"},
                    {"rows", Json::array({row("huber, clean", 0.01, 7e-4)})}};
  EXPECT_EQ(inverse_summary({losses, scores}, folder()).at("validation_E"), 2e-4);
  EXPECT_EQ(inverse_summary({losses}, folder()).at("validation_E"), 7e-4);
}

}  // namespace
}  // namespace kappamu::studies
