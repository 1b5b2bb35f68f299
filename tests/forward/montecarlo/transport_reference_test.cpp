// Against solutions by two independent programs, Monte Carlo transport and another finite-volume
// code (shared/data/transport-reference). Diffusion is held to the finite volumes within their
// stated uncertainty plus its own discretisation error; the physics to Monte Carlo within what
// diffusion can do there. Skipped where the data or the JSON reader are absent.
#include <gtest/gtest.h>

#if __has_include(<nlohmann/json.hpp>)
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "device/device_info.h"
#include "forward/grid/power_balance.h"
#include "tests/forward/grid/test_tools.h"
#include "tests/reference_data.h"

namespace kappamu::forward {
namespace {

using nlohmann::json;
using testing::Values;

struct Scene {
  json file;
  std::array<int, 3> size_mm{};
  std::array<double, 4> patch{};
  double irradiance = 0.0;
  std::array<int, 2> pixels{};

  double sigma_a(double x, double y, double z) const { return coefficient("sigma_a", x, y, z); }
  double sigma_s(double x, double y, double z) const {
    return coefficient("sigma_s_prime", x, y, z);
  }

 private:
  double coefficient(const char* name, double x, double y, double z) const {
    const json& c = file["coefficients"][name];
    if (c.is_number()) return c;
    const double h = file["coefficients"]["voxel_mm"];
    return c[static_cast<std::size_t>(z / h)][static_cast<std::size_t>(y / h)]
            [static_cast<std::size_t>(x / h)];
  }
};

/// The unlit part of a map, or all of it: light edges are where source models differ most.
enum class Part { all, unlit };

struct Maps {
  Values front, back;  ///< [j][i], pixel means of exitance
  std::array<double, 6> exiting{};
  double absorbed = 0.0;
};

class TransportReference : public ::testing::Test {
 protected:
  static constexpr SolveOptions tight{1e-8, 300};

  static std::optional<Scene> load(const std::string& name) {
    const auto path = reference_data("transport-reference") / (name + ".json");
    std::ifstream in(path);
    if (!in) return std::nullopt;
    Scene scene;
    scene.file = json::parse(in);
    scene.size_mm = scene.file["geometry"]["size_mm"];
    scene.patch = scene.file["illumination"]["patch_x0_x1_y0_y1_mm"];
    scene.irradiance = scene.file["illumination"]["irradiance_before_fresnel"];
    scene.pixels = scene.file["maps"]["pixels_x_y"];
    return scene;
  }

  /// Solves on voxels of 1/per_mm. `light_factor` scales the irradiance.
  static Maps solve(const Scene& scene, GridSetup setup, int per_mm, double light_factor = 1.0) {
    const double h = 1.0 / per_mm;
    setup.shape = {scene.size_mm[0] * per_mm, scene.size_mm[1] * per_mm, scene.size_mm[2] * per_mm,
                   h};
    const GridShape& s = setup.shape;
    Medium medium{Volume<double>(s), Volume<double>(s)};
    for (int z = 0; z < s.nz; ++z) {
      for (int y = 0; y < s.ny; ++y) {
        for (int x = 0; x < s.nx; ++x) {
          const double px = (x + 0.5) * h, py = (y + 0.5) * h, pz = (z + 0.5) * h;
          const double a = scene.sigma_a(px, py, pz);
          medium.mu(x, y, z) = a;
          medium.kappa(x, y, z) = 1.0 / (3.0 * (a + scene.sigma_s(px, py, pz)));
        }
      }
    }
    Values light(static_cast<std::size_t>(s.nx) * s.ny, 0.0);
    for (int y = 0; y < s.ny; ++y) {
      for (int x = 0; x < s.nx; ++x) {
        const double px = (x + 0.5) * h, py = (y + 0.5) * h;
        const bool lit = px > scene.patch[0] && px < scene.patch[1] && py > scene.patch[2] &&
                         py < scene.patch[3];
        if (lit) light[static_cast<std::size_t>(y) * s.nx + x] = light_factor * scene.irradiance;
      }
    }
    const std::string device = device::list_devices().empty() ? "reference" : "auto";
    const SolverChoice choice = make_grid_solver(setup, device);
    GridSolver& solver = *choice.solver;
    solver.set_medium(medium.kappa.values(), medium.mu.values());
    const auto solution = testing::solve_light(solver, light, 1, tight);
    EXPECT_EQ(solution.report.termination, Termination::converged) << solution.report.message;
    std::array<Values, 6> maps;
    for (std::size_t f = 0; f < 6; ++f) {
      maps[f] = testing::exitance(solver, *solution.phi, all_faces[f], light);
    }
    const PowerBalance balance = power_balance(solver, medium, *solution.phi, light, maps).front();
    return {pixel_means(maps[4], s, scene), pixel_means(maps[5], s, scene), balance.exiting,
            balance.absorbed};
  }

  static Values pixel_means(const Values& map, const GridShape& s, const Scene& scene) {
    const int width = scene.pixels[0], height = scene.pixels[1];
    const int n = s.nx / width;
    Values means(static_cast<std::size_t>(width) * height, 0.0);
    for (int y = 0; y < s.ny; ++y) {
      for (int x = 0; x < s.nx; ++x) {
        means[static_cast<std::size_t>(y / n) * width + x / n] +=
            map[static_cast<std::size_t>(y) * s.nx + x] / (n * n);
      }
    }
    return means;
  }

  /// ‖ours − theirs‖/‖theirs‖, ours extrapolated from two grids (order 2), and by how much that
  /// extrapolation moved the finer one: its own error is at most about half of it.
  struct Comparison {
    double difference, correction;
  };
  static Comparison compare(const Scene& scene, const Values& coarse, const Values& fine,
                            const json& map, double factor, Part part) {
    const int width = scene.pixels[0];
    const double pixel = static_cast<double>(scene.size_mm[0]) / width;
    double difference = 0.0, correction = 0.0, norm = 0.0;
    for (std::size_t k = 0; k < fine.size(); ++k) {
      const auto i = static_cast<int>(k) % width, j = static_cast<int>(k) / width;
      const double x = (i + 0.5) * pixel, y = (j + 0.5) * pixel;
      // One pixel around the patch is left out with it.
      const bool lit = x > scene.patch[0] - pixel && x < scene.patch[1] + pixel &&
                       y > scene.patch[2] - pixel && y < scene.patch[3] + pixel;
      if (part == Part::unlit && lit) continue;
      const double theirs = map[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)];
      const double step = (fine[k] - coarse[k]) / 3.0;
      const double ours = factor * (fine[k] + step);
      difference += (ours - theirs) * (ours - theirs);
      correction += factor * factor * step * step;
      norm += theirs * theirs;
    }
    return {std::sqrt(difference / norm), std::sqrt(correction / norm)};
  }

  static void expect_agreement(const Scene& scene, const Values& coarse, const Values& fine,
                               const char* model, const std::string& map, double factor,
                               Part part) {
    const json& truth = scene.file["truth"][model];
    const std::string side = map.find("back") != std::string::npos ? "back" : "front";
    const double stated = truth[side + "_uncertainty"]["rel_l2_error_estimate"];
    const Comparison c = compare(scene, coarse, fine, truth[map], factor, part);
    EXPECT_LE(c.difference, stated + 0.5 * c.correction)
        << model << " " << map << ": stated " << stated << ", own correction " << c.correction;
    ::testing::Test::RecordProperty(std::string(model) + "_" + map, std::to_string(c.difference));
  }

  /// Finer and coarser voxels per mm.
  static void agree_with_finite_volumes(const Scene& scene, int coarse, int fine) {
    {
      SCOPED_TRACE("first-collision source, A exact");
      const GridSetup setup;
      const Maps a = solve(scene, setup, coarse), b = solve(scene, setup, fine);
      expect_agreement(scene, a.back, b.back, "fv_volume", "back", 1.0, Part::all);
      expect_agreement(scene, a.front, b.front, "fv_volume", "front", 1.0, Part::all);
      const json& totals = scene.file["truth"]["fv_volume"]["totals"];
      EXPECT_NEAR(b.exiting[5], totals["back"], 0.02 * totals["back"].get<double>());
    }
    {
      SCOPED_TRACE("the paper's convention");
      GridSetup setup;
      setup.source = SourceModel::boundary;
      setup.convention = Convention::wang2008;
      const Maps a = solve(scene, setup, coarse), b = solve(scene, setup, fine);
      const double to_radiance = 1.0 / std::numbers::pi;
      expect_agreement(scene, a.back, b.back, "wang_literal", "radiance_back", to_radiance,
                       Part::all);
      expect_agreement(scene, a.front, b.front, "wang_literal", "radiance_front", to_radiance,
                       Part::unlit);
    }
    {
      SCOPED_TRACE("boundary source, A = (1+F_dr)/(1-F_dr)");
      // Their A is not the physical convention's. A is all of η that the matrix knows, so the η
      // with that A, and light scaled to their q, make their problem.
      const double wanted_A = scene.file["truth"]["fv_boundary"]["A"];
      double low = 1.3, high = 2.0;
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (boundary_constants(middle).A < wanted_A ? low : high) = middle;
      }
      GridSetup setup;
      setup.source = SourceModel::boundary;
      setup.eta = low;
      const BoundaryConstants theirs = boundary_constants(1.3), ours = boundary_constants(low);
      const double factor = (theirs.normal_transmittance / (1 - theirs.r_phi)) /
                            (ours.normal_transmittance / (1 - ours.r_phi));
      const Maps a = solve(scene, setup, coarse, factor), b = solve(scene, setup, fine, factor);
      expect_agreement(scene, a.back, b.back, "fv_boundary", "back", 1.0, Part::all);
      expect_agreement(scene, a.front, b.front, "fv_boundary", "front", 1.0, Part::unlit);
    }
  }

  /// Relative differences of the default model's totals that diffusion may have from Monte Carlo's,
  /// whose own standard errors are below 0.1 %.
  struct Allowed {
    double front, back, absorbed;
  };
  static void agree_with_monte_carlo(const Scene& scene, int per_mm, const Allowed& allowed) {
    const Maps maps = solve(scene, {}, per_mm);
    const json& totals = scene.file["truth"]["mc"]["totals"];
    const double front = totals["front"], back = totals["back"], absorbed = totals["absorbed"];
    EXPECT_NEAR(maps.exiting[4], front, allowed.front * front);
    EXPECT_NEAR(maps.exiting[5], back, allowed.back * back);
    EXPECT_NEAR(maps.absorbed, absorbed, allowed.absorbed * absorbed);
  }
};

TEST_F(TransportReference, MarbleSlabAgreesWithFiniteVolumes) {
  const auto scene = load("h1_marble_3mm");
  if (!scene) GTEST_SKIP() << "shared/data/transport-reference is absent";
  agree_with_finite_volumes(*scene, 4, 8);
}

TEST_F(TransportReference, MarbleSlabAgreesWithMonteCarlo) {
  const auto scene = load("h1_marble_3mm");
  if (!scene) GTEST_SKIP() << "shared/data/transport-reference is absent";
  // Measured 0.35 %, 0.8 %, 3.1 %; the absorption is that near the source, where diffusion is
  // weakest.
  agree_with_monte_carlo(*scene, 8, {0.006, 0.015, 0.05});
}

TEST_F(TransportReference, InclusionsAgreeWithFiniteVolumes) {
  const auto scene = load("c6_inclusions");
  if (!scene) GTEST_SKIP() << "shared/data/transport-reference is absent";
  agree_with_finite_volumes(*scene, 2, 4);
}

TEST_F(TransportReference, InclusionsAgreeWithMonteCarloAsFarAsDiffusionCan) {
  const auto scene = load("c6_inclusions");
  if (!scene) GTEST_SKIP() << "shared/data/transport-reference is absent";
  // The mean free path is comparable with the inclusions: the reference's own diffusion is 8 % off
  // on the back. Measured here 0.4 %, 9.6 %, 1.5 % on 0.25 mm voxels.
  agree_with_monte_carlo(*scene, 4, {0.01, 0.12, 0.03});
}

}  // namespace
}  // namespace kappamu::forward
#endif
