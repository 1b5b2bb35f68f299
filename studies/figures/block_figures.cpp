#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "data_synthetic/scene/materials.h"
#include "inverse/fit/fit.h"
#include "inverse/problem/predict.h"
#include "io/volume/volume_file.h"
#include "studies/figures/figures_bench.h"
#include "studies/inverse/inverse_fit.h"
#include "studies/inverse/inverse_samples.h"
#include "tests/cases/inverse_case.h"
#include "tests/cases/media.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

constexpr double figure_noise = 0.01;

/// [v][u] of a layer, the seen face's first.
Json layer(const Volume<double>& volume, Face face, int depth) {
  const GridShape& shape = volume.shape();
  const FaceShape size = face_shape(shape, face);
  Json rows = Json::array();
  for (int v = 0; v < size.nv; ++v) {
    Json row = Json::array();
    for (int u = 0; u < size.nu; ++u) {
      row.push_back(volume.values()[face_cell(shape, face, u, v, depth)]);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

/// [v][u] of the first pattern.
Json first_image(const std::vector<float>& values, FaceShape size) {
  Json rows = Json::array();
  for (int v = 0; v < size.nv; ++v) {
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(v) * size.nu;
    rows.push_back(std::vector<float>(begin, begin + size.nu));
  }
  return rows;
}

inverse::ChannelFit fit_of(const SurfaceMeasurements& measured, inverse::FitOptions options,
                           const Request& request, Progress& progress) {
  options.solver.backend.device = request.device;
  return inverse::fit_channel(measured, 0, options, {}, progress, {}, {});
}

synthetic::SampleModel small_sample(const std::string& name, const Request& request) {
  const synthetic::SampleModel whole = synthetic::make_sample(name, request.seed);
  if (request.size == Size::full) return whole;
  const GridShape& g = whole.grid;
  const bool quick = request.size == Size::quick;
  const auto across = [&](int n) { return quick ? 10 : std::clamp(n / 8, 12, 24); };
  return synthetic::make_sample(
      name, request.seed,
      std::array<int, 3>{across(g.nx), across(g.ny), quick ? 5 : std::max(6, g.nz / 3)});
}

/// A disc of light that no fit sees.
std::vector<double> disc_light(FaceShape face) {
  std::vector<double> light;
  for (int v = 0; v < face.nv; ++v) {
    for (int u = 0; u < face.nu; ++u) {
      const double x = (u + 0.5) / face.nu - 0.42, y = (v + 0.5) / face.nv - 0.55;
      light.push_back(x * x + y * y < 0.06 ? 1.0 : 0.0);
    }
  }
  return light;
}

/// What a volume shows under light that the fit did not see, beside the truth's.
Json relit(const Medium& medium, const SurfaceMeasurements& exposed) {
  const FaceShape face = face_shape(exposed.grid, exposed.seen_face);
  return {{"truth", first_image(exposed.value, face)},
          {"found", first_image(inverse::predict(medium, exposed, {}), face)}};
}

}  // namespace

void figure_samples(const Request& request, Progress& progress, const Save& save) {
  const int most = request.size == Size::quick ? 2 : request.count("most", 8);
  constexpr int shown_side = 4;  // of 16 images
  Json rows = Json::array(), faces = Json::array();
  for (const std::string& name :
       request.has("sample") ? request.words("sample") : paper_samples()) {
    const synthetic::SampleModel sample = small_sample(name, request);
    Block block;
    block.grid = sample.grid;
    block.lit = sample.lit_face();
    block.seen = sample.seen_face();
    block.noise = figure_noise;
    block.precision = forward::Precision::single_precision;
    const std::array<Medium, 3> truth = synthetic::sample_medium(sample, block.grid.refined(2));
    const FaceShape lit = face_shape(block.grid, block.lit);
    const std::vector<double> single = single_voxel_light(lit, 16, 11), disc = disc_light(lit);
    const bool front_lit = block.lit == block.seen;
    io::VolumeSet found;
    found.channels = {"R", "G", "B"};
    // One patch, seen from where it falls, leaves nothing in the dark.
    for (int n = front_lit ? 2 : 1; n <= most; ++n) {
      const int shown = std::min(shown_side, most);
      for (std::size_t c = 0; c < truth.size(); ++c) {
        if (c != 1 && n != shown) continue;
        const inverse::CoefficientPair fields = inverse::to_fields(truth[c]);
        SurfaceMeasurements measured = expose_patches(block, fields, n);
        add_noise(measured, figure_noise, request.seed + c);
        const inverse::ChannelFit fit = fit_of(measured, {}, request, progress);
        if (c == 1) {
          rows.push_back(
              {{"sample", name},
               {"n", n},
               {"images", n * n},
               {"grid", {block.grid.nx, block.grid.ny, block.grid.nz}},
               {"E", appearance_error(fit.medium, expose(block, fields, single))},
               {"patches_E", appearance_error(fit.medium, expose_patches(block, fields, 8))},
               {"chi2", fit.report.chi2_per_value},
               {"seconds", fit.report.seconds}});
        }
        if (n == shown) {
          found.media.push_back(fit.medium);
          const Medium whole = inverse::to_medium(fields, block.grid.refined(2));
          faces.push_back({{"sample", name},
                           {"channel", c},
                           {"images", n * n},
                           {"kappa", layer(fit.medium.kappa, block.seen, 0)},
                           {"mu", layer(fit.medium.mu, block.seen, 0)},
                           {"true_kappa", layer(whole.kappa, block.seen, 0)},
                           {"true_mu", layer(whole.mu, block.seen, 0)},
                           {"relit", relit(fit.medium, expose(block, fields, disc))}});
        }
      }
      save({{"rows", rows}, {"faces", faces}});
    }
    io::write_volume_folder(request.folder / ("volume-" + name), found);
  }
}

void figure_weights(const Request& request, Progress& progress, const Save& save) {
  const bool quick = request.size == Size::quick;
  Block block;
  block.grid = quick ? GridShape{10, 10, 5, 0.5} : GridShape{20, 20, 8, 0.5};
  if (request.size == Size::full) block.grid = {32, 32, 10, 0.5};
  block.noise = figure_noise;
  const inverse::CoefficientPair fields = make_truth(block.grid.refined(2), {.seed = request.seed});
  const SurfaceMeasurements measured = measure(block, fields, quick ? 2 : 4, request.seed);
  const Medium truth = inverse::to_medium(fields, block.grid.refined(2));
  const int depth = block.grid.nz;
  const FaceShape face = face_shape(block.grid, block.seen);
  const SurfaceMeasurements single =
      expose(block, fields, single_voxel_light(face_shape(block.grid, block.lit), 16, 11));

  std::vector<Variant> variants;
  for (const Variant& variant : inverse_variants()) {
    if (variant.name == "wang2008-printed") {
      for (const double weight : {1e-4, 1e-5, 1e-6}) {
        variants.push_back(variant);
        variants.back().options.path.weight = weight;
      }
    }
  }
  variants.push_back({"default", "our default", {}});
  Json rows = Json::array(), fits = Json::array();
  const Json input = first_image(measured.value, face);
  Json true_slices = Json::array();
  for (int k = 0; k < depth; ++k) {
    true_slices.push_back({{"kappa", layer(truth.kappa, block.seen, 2 * k)},
                           {"mu", layer(truth.mu, block.seen, 2 * k)}});
  }
  for (const Variant& variant : variants) {
    const inverse::ChannelFit fit = fit_of(measured, variant.options, request, progress);
    const DepthError errors = depth_error(fit.medium, fields, block.seen);
    rows.push_back({{"variant", variant.name},
                    {"weight", fit.report.weight},
                    {"E", appearance_error(fit.medium, single)},
                    {"chi2", fit.report.chi2_per_value},
                    {"kappa_error_face", errors.kappa.front()},
                    {"kappa_error_middle", errors.kappa[errors.kappa.size() / 2]},
                    {"mu_error_face", errors.mu.front()},
                    {"mu_error_middle", errors.mu[errors.mu.size() / 2]},
                    {"solves", fit.report.solves.total()},
                    {"seconds", fit.report.seconds}});
    Json slices = Json::array();
    for (int k = 0; k < depth; ++k) {
      slices.push_back({{"kappa", layer(fit.medium.kappa, block.seen, k)},
                        {"mu", layer(fit.medium.mu, block.seen, k)}});
    }
    fits.push_back({{"variant", variant.name},
                    {"weight", fit.report.weight},
                    {"image", first_image(inverse::predict(fit.medium, measured, {}), face)},
                    {"slices", std::move(slices)}});
    save({{"grid", {block.grid.nx, block.grid.ny, block.grid.nz}},
          {"image", input},
          {"truth", true_slices},
          {"fits", fits},
          {"rows", rows}});
  }
}

}  // namespace kappamu::studies
