// A block photographed by Mitsuba 3 (tests/data/mitsuba-block/SOURCE.md): another program's random
// walk through another program's glass, merged by `kappamu run`, is fitted blind.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

#include "inverse/validation/validated_fit.h"
#include "io/measurements_file.h"
#include "io/npy.h"
#include "tests/cases/inverse_case.h"
#include "tests/reference_data.h"

namespace kappamu::pipeline {
namespace {

using test_cases::Block;

Volume<double> read_volume(const std::string& name, const GridShape& shape) {
  const std::vector<float> values = io::read_npy(reference_data("mitsuba-block") / name).values;
  return {shape, {values.begin(), values.end()}};
}

/// log of every voxel, which is constant, on a grid twice as fine.
std::vector<double> fine_log(const Volume<double>& volume) {
  const GridShape fine = volume.shape().refined(2);
  std::vector<double> logs;
  for (int z = 0; z < fine.nz; ++z) {
    for (int y = 0; y < fine.ny; ++y) {
      for (int x = 0; x < fine.nx; ++x) logs.push_back(std::log(volume(x / 2, y / 2, z / 2)));
    }
  }
  return logs;
}

/// One patch of 2 × 2 voxels a pattern, all over the face.
std::vector<double> small_patches(const GridShape& grid) {
  std::vector<double> light;
  for (int v = 0; v < grid.ny; v += 2) {
    for (int u = 0; u < grid.nx; u += 2) {
      for (int y = 0; y < grid.ny; ++y) {
        for (int x = 0; x < grid.nx; ++x)
          light.push_back(x / 2 == u / 2 && y / 2 == v / 2 ? 1.0 : 0.0);
      }
    }
  }
  return light;
}

double rms_log(const Volume<double>& found, const Volume<double>& truth) {
  double squares = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    squares += std::pow(std::log(found[i] / truth[i]), 2);
  return std::sqrt(squares / static_cast<double>(truth.size()));
}

TEST(MitsubaBlock, FittedBlindItPredictsOtherLight) {
  const SurfaceMeasurements fitted =
      io::read_measurements(reference_data("mitsuba-block") / "measurements");
  const SurfaceMeasurements held =
      io::read_measurements(reference_data("mitsuba-block") / "measurements_validate");
  inverse::FitOptions options;
  options.solver.backend.device = "reference";
  Progress silent;
  const inverse::ValidatedFit found = inverse::fit_validated(
      inverse::split_validation(fitted, {}, held), 0, options, {}, {}, silent);

  const Medium truth{read_volume("kappa_Y.npy", fitted.grid), read_volume("mu_Y.npy", fitted.grid)};
  const SurfaceMeasurements other =
      test_cases::expose(Block{.grid = fitted.grid}, {fine_log(truth.kappa), fine_log(truth.mu)},
                         small_patches(fitted.grid));
  const Medium plain{Volume<double>(fitted.grid, found.fit.report.homogeneous_kappa),
                     Volume<double>(fitted.grid, found.fit.report.homogeneous_mu)};
  const double E = test_cases::appearance_error(found.fit.medium, other);
  const double homogeneous_E = test_cases::appearance_error(plain, other);
  const double held_E = found.score->error.E(), held_noise = found.score->error.noise_E();
  const double kappa = rms_log(found.fit.medium.kappa, truth.kappa);
  const double mu = rms_log(found.fit.medium.mu, truth.mu);
  std::printf(
      "E under patches of 2 x 2 voxels %.2e (homogeneous block %.2e), held out by Mitsuba %.2e "
      "(noise %.2e), chi2 per value %.2f, log kappa %.2f, log mu %.2f\n",
      E, homogeneous_E, held_E, held_noise, found.fit.report.chi2_per_value, kappa, mu);
}

}  // namespace
}  // namespace kappamu::pipeline
