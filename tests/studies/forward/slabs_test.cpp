// The slabs' own Monte Carlo, slides and spheres: laws, published values, the voxel referee, and
// real measurements where the data are at hand.
#include "studies/forward/slabs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "device/device_info.h"
#include "forward/forward_model.h"
#include "forward/lateral/slides.h"
#include "tests/own_folder.h"
#include "tests/reference_data.h"
#include "tests/sentence.h"

namespace kappamu::studies {
namespace {

namespace fs = std::filesystem;

constexpr double standard_errors = 4.0;  // one test in 16,000 fails by chance; seeds are fixed

TEST(Slide, OfIndexOneOrOfTheSampleIsNone) {
  for (const double c : {0.3, 0.7, 0.9, 1.0}) {
    EXPECT_NEAR(forward::slide_reflectance(1.33, 1.0, c), fresnel_internal(1.33, c), 1e-12);
    EXPECT_NEAR(forward::slide_reflectance(1.33, 1.33, c), fresnel_internal(1.33, c), 1e-12);
  }
  const BoundaryConstants with = forward::slide_constants(1.4, 1.0),
                          without = boundary_constants(1.4);
  EXPECT_NEAR(with.A, without.A, 1e-5 * without.A);  // the midpoint rule's
  EXPECT_NEAR(with.r_phi, without.r_phi, 1e-5);
}

TEST(Slide, ReflectsMoreThanNoneAtNormalIncidence) {
  const double n = 1.33, slide = 1.5;
  const double first = std::pow((n - slide) / (n + slide), 2), second = 0.04;
  EXPECT_NEAR(forward::slide_reflectance(n, slide, 1.0),
              first + (1 - first) * (1 - first) * second / (1 - first * second), 1e-12);
  EXPECT_GT(forward::slide_constants(n, slide).A, forward::slide_constants(n, 1.0).A);
}

/// van de Hulst (1980), as quoted for MCML: albedo 0.9, optical depth 2, g = 0.75, no surfaces.
TEST(SlabPhotons, AgreeWithPublishedTotals) {
  const OpticalSlab slab{1.0, 1.0, 0.2, 1.0, 9.0 * 0.25, 0.75};
  const SlabTotals totals = trace_slab(slab, Incidence::normal, 200'000, 1);
  EXPECT_NEAR(totals.reflected, 0.09739, standard_errors * totals.reflected_error);
  EXPECT_NEAR(totals.transmitted, 0.66096, standard_errors * totals.transmitted_error);
}

TEST(SlabPhotons, LoseNothingWithoutAbsorption) {
  const OpticalSlab slab{1.33, 1.5, 2.0, 0.0, 1.5, 0.5};
  for (const Incidence incidence : {Incidence::normal, Incidence::diffuse}) {
    const SlabTotals totals = trace_slab(slab, incidence, 20'000, 3);
    EXPECT_NEAR(totals.reflected + totals.transmitted, 1.0, 1e-12);
  }
}

/// Without scattering the answer is a geometric series, and diffusion's closed form has it too.
TEST(SlabPhotons, FollowABeamThroughClearSlabs) {
  const OpticalSlab slab{1.33, 1.507, 1.0, 0.4, 1e-9, 0.0};
  const SlabTotals traced = trace_slab(slab, Incidence::normal, 200'000, 5);
  const SlabTotals closed = diffuse_slab(slab, Incidence::normal);
  EXPECT_NEAR(traced.reflected, closed.reflected, standard_errors * traced.reflected_error);
  EXPECT_NEAR(traced.transmitted, closed.transmitted, standard_errors * traced.transmitted_error);
}

TEST(SlabPhotons, AgreeWithTheVoxelReferee) {
  if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device";
  const double absorption = 0.05, scattering = 1.2, thickness = 3.0, g = 0.6;
  forward::ForwardProblem problem;
  problem.setup.shape = {1, 1, 3, thickness / 3};
  problem.setup.sides = Sides::mirror;
  const double kappa = 1 / (3 * (absorption + scattering));
  problem.medium = {Volume<double>(problem.setup.shape, kappa),
                    Volume<double>(problem.setup.shape, absorption)};
  problem.irradiance = {1.0};
  forward::ForwardOptions options;
  options.photons = 100'000;
  options.anisotropy = g;
  Progress silent;
  const auto voxels = forward::make_forward_model("montecarlo")->solve(problem, options, silent);
  const OpticalSlab slab{problem.setup.eta, 1.0, thickness, absorption, scattering, g};
  const SlabTotals totals = trace_slab(slab, Incidence::normal, 100'000, 7);
  const double specular = 1.0 - boundary_constants(problem.setup.eta).normal_transmittance;
  const double area = 1.0;
  const auto noise = [&](double ours, std::size_t face) {
    return standard_errors * std::hypot(ours, voxels.standard_error[face][0]);
  };
  // Their unscattered light leaves by both faces; the far one's share is all but r² e^(−2τ) of it.
  const double unscattered = voxels.balance[0].unscattered / area;
  EXPECT_NEAR(totals.reflected, specular + voxels.exitance[4][0], noise(totals.reflected_error, 4));
  EXPECT_NEAR(totals.transmitted, voxels.exitance[5][0] + unscattered,
              noise(totals.transmitted_error, 5));
}

TEST(Sphere, GainGrowsWithWhatItsPortsReflect) {
  MeasuredSlab m;
  m.reflection.diameter = 200;
  m.reflection.sample_port = m.reflection.third_port = 20;
  m.reflection.detector_port = 1;
  m.reflection.wall_reflectance = 0.95;
  EXPECT_GT(m.reflection.gain(0.9, 0.0), m.reflection.gain(0.1, 0.0));
  EXPECT_GT(m.reflection.gain(0.1, 0.9), m.reflection.gain(0.1, 0.0));
  m.reflection.sample_port = m.reflection.third_port = m.reflection.detector_port = 0;
  EXPECT_NEAR(m.reflection.gain(0.5, 0.5), 1 / (1 - 0.95), 1e-12);
}

class SlabFolder : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  std::string sentence() const {
    return sentence_of([&] { read_measured_slabs(folder_); });
  }
  static constexpr const char* head = "file,row,MR,MRf,MT,MTf,mua,musp,g,flag\n";
  const OwnFolder folder_;
};

TEST_F(SlabFolder, RowsOverruleTheHeaderAndUnconvergedOnesAreLeftOut) {
  write("peer_iad.csv", std::string(head) +
                            "a,1,0.3,0.3,0.2,0.2,0.1,1.5,0.5,*\n"
                            "a,2,0.3,0.3,0.2,0.2,0.1,1.5,0.5,R\n"
                            "a,3,0.4,0.4,0.2,0.2,0.1,1.5,0.5,*\n");
  write("a.rxt",
        "IAD1 # x\n1.33 # n\n1.5\n2.0\n1\n4\n0.98\n\n1\n100\n10\n11\n1\n0.9\n101\n12\n13\n2\n0.8\n"
        "r t n\n0.3 0.2 1.34\n0.3 0.2 1.35\n0.4 0.2 1.36\n");
  const auto slabs = read_measured_slabs(folder_.path());
  ASSERT_EQ(slabs.size(), 2U);
  EXPECT_EQ(slabs[1].row, "3");
  EXPECT_DOUBLE_EQ(slabs[1].n_sample, 1.36);
  EXPECT_DOUBLE_EQ(slabs[0].n_slide, 1.5);
  EXPECT_DOUBLE_EQ(slabs[0].thickness, 2.0);
  EXPECT_EQ(slabs[0].spheres, 1);
  EXPECT_DOUBLE_EQ(slabs[0].transmission.wall_reflectance, 0.8);
  EXPECT_DOUBLE_EQ(slabs[0].standard, 0.98);
  EXPECT_DOUBLE_EQ(slabs[0].transmission_standard, 1.0);  // the header's is of reflectance alone
}

TEST_F(SlabFolder, SaysWhatItCannotRead) {
  fs::remove(folder_ / "peer_iad.csv");
  EXPECT_THAT(sentence(), ::testing::HasSubstr("--data names the folder"));
  write("peer_iad.csv", std::string(head) + "a,1,0.3\n");
  EXPECT_THAT(sentence(), ::testing::HasSubstr("peer_iad.csv:2: 3 columns"));
  write("peer_iad.csv", std::string(head) + "a,1,0.3,0.3,0.2,0.2,x,1.5,0.5,*\n");
  write("a.rxt", "IAD1\n1.33\n");
  EXPECT_THAT(sentence(), ::testing::HasSubstr("header ends after 1"));
  write("a.rxt", "IAD2\n");
  EXPECT_THAT(sentence(), ::testing::HasSubstr("IAD1"));
}

/// The coefficients are an exact transport program's: Monte Carlo must give the measured values
/// back, diffusion where it holds.
TEST(RealSlabs, MonteCarloGivesTheMeasurementsBack) {
  const fs::path folder = reference_data("slab-rt-iad");
  if (!fs::exists(folder / "peer_iad.csv")) GTEST_SKIP() << "shared/data/slab-rt-iad is absent";
  SlabOptions options;
  options.every = 60;
  options.photons = 10'000;
  Progress silent;
  const auto rows = compare_slabs(read_measured_slabs(folder), options, silent);
  ASSERT_GT(rows.size(), 40U);
  // Eight quadrature points and δ-M of the program that made the coefficients.
  constexpr double theirs = 0.005;
  for (const SlabComparison& row : rows) {
    const MeasuredSlab& m = row.measured;
    EXPECT_NEAR(row.monte_carlo.reflectance, m.reflectance,
                theirs + standard_errors * row.monte_carlo.reflectance_error)
        << m.file << " " << m.row;
    EXPECT_NEAR(row.monte_carlo.transmittance, m.transmittance,
                theirs + standard_errors * row.monte_carlo.transmittance_error)
        << m.file << " " << m.row;
    if (m.albedo() < 0.99) continue;
    EXPECT_NEAR(row.diffusion.reflectance, m.reflectance, 0.01) << m.file << " " << m.row;
    EXPECT_NEAR(row.diffusion.transmittance, m.transmittance, 0.01) << m.file << " " << m.row;
  }
}

}  // namespace
}  // namespace kappamu::studies
