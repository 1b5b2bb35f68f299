// How often data that are not what they claim to be are reported, and how often right ones are.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "inverse/fit/fit.h"
#include "studies/limits/limits.h"
#include "tests/cases/limit_inverse_case.h"
#include "tests/cases/media.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

struct Kind {
  std::string name;
  std::function<Figure3(double kappa, double mu, std::uint64_t seed)> figure;
};

std::vector<Kind> kinds() {
  const auto mixed = [](double k, double m, std::uint64_t seed) {
    const Figure3 layers = random_layers(k, m, seed);
    const Figure3 structure = structured_block(1.0, 1.0, 0.7, seed + 50);
    return [=](double a, double b, double c) {
      const Material one = layers(a, b, c), two = structure(a, b, c);
      return Material{one.log_kappa + two.log_kappa, one.log_mu + two.log_mu};
    };
  };
  return {{"homogeneous", [](double k, double m, std::uint64_t) { return even_block(k, m); }},
          {"layers", random_layers},
          {"structure",
           [](double k, double m, std::uint64_t s) { return structured_block(k, m, 1.0, s); }},
          {"layers and structure", mixed}};
}

constexpr const char* right = "right";
constexpr int right_seeds = 25, wrong_seeds = 10;

struct Wrong {
  std::string name{};
  Mistake mistake{};
  double eta = 1.3;
};

}  // namespace

Json limit_consistency(const Request& request, Progress& progress) {
  Json rows = Json::array();
  constexpr double noise = 0.01;
  constexpr int fine = 2;
  const std::array<double, 3> kappas{0.12, 0.2, 0.3};
  const std::array<double, 2> mus{0.005, 0.03};
  const std::vector<Wrong> wrongs{{right, {}},
                                  {"scale 1.2", {.scale = 1.2}},
                                  {"scale 1.5", {.scale = 1.5}},
                                  {"scale 2", {.scale = 2.0}},
                                  {"scale 0.5", {.scale = 0.5}},
                                  {"0.3 voxels off", {.shift = 0.3}},
                                  {"1 voxel off", {.shift = 1}},
                                  {"3 voxels off", {.shift = 3}},
                                  {"eta 1.3 for 1.5", {.stated_eta = 1.3}, 1.5}};
  const Block block{.grid = {12, 12, 6, 0.5}};
  const std::vector<double> light = bar_light(block.grid, block.lit, 8);
  inverse::FitOptions options;
  options.solver.backend.device = request.device;
  Progress silent;
  for (const Kind& kind : kinds()) {
    for (const Wrong& wrong : wrongs) {
      progress.update("consistency", 0.0, kind.name + ", " + wrong.name);
      const int seeds = wrong.name == right ? right_seeds : wrong_seeds;
      int scale = 0, shift = 0, eta = 0, volumes = 0;
      double sum = 0.0, squares = 0.0, voxels = 0.0;
      for (int s = 0; s < seeds; ++s) {
        const std::uint64_t seed = request.seed - 1 + static_cast<std::uint64_t>(s);
        SurfaceMeasurements m = expose_figure(
            block, kind.figure(kappas[seed % kappas.size()], mus[seed % mus.size()], seed), light,
            fine, wrong.eta);
        spoil(m, noise, wrong.mistake, seed + 1);
        const inverse::ChannelFit fit =
            inverse::fit_channel(m, 0, options, inverse::Checkpoint{}, silent);
        const inverse::Consistency& c = fit.report.consistency;
        volumes += c.by_volume ? 1 : 0;
        eta += c.other_eta ? 1 : 0;
        scale += c.scale_is_wrong() && !c.other_eta ? 1 : 0;
        shift += c.is_shifted() ? 1 : 0;
        sum += c.log_scale.value / seeds;
        squares += c.log_scale.value * c.log_scale.value / seeds;
        voxels += std::hypot(c.shift_u.value, c.shift_v.value) / seeds;
      }
      rows.push_back({{"block", kind.name},
                      {"data", wrong.name},
                      {"blocks", seeds},
                      {"fitted by volumes", 1.0 * volumes / seeds},
                      {"factor found", std::exp(sum)},
                      {"its spread", std::sqrt(std::max(0.0, squares - sum * sum))},
                      {"shift found", voxels},
                      {"reported: scale", 1.0 * scale / seeds},
                      {"reported: shift", 1.0 * shift / seeds},
                      {"reported: eta", 1.0 * eta / seeds}});
    }
  }
  return rows;
}

}  // namespace kappamu::studies
