#include "studies/forward/slabs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "forward/analytic/layered_mode.h"
#include "forward/lateral/slides.h"
#include "forward/light/beam_column.h"
#include "studies/subjects.h"

namespace kappamu::studies {

namespace {

/// Standard error that totals of an integrating sphere are taken to have [share of incident light].
constexpr double sphere_error = 0.002;

/// ∫₀¹ f dc by the midpoint rule.
template <class F>
double mean(F f) {
  constexpr int n = 20000;
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += f((i + 0.5) / n);
  return sum / n;
}

/// Reflectance of the surface for Lambertian light from outside.
double diffuse_surface_reflectance(const OpticalSlab& slab) {
  return mean([&](double c) {
    const double inside = std::sqrt(1.0 - (1.0 - c * c) / (slab.n_sample * slab.n_sample));
    return 2.0 * c * forward::slide_reflectance(slab.n_sample, slab.n_slide, inside);
  });
}

/// Specular and unscattered light, exact whatever the model of the rest.
SlabTotals unscattered(const OpticalSlab& slab) {
  const double r = forward::slide_reflectance(slab.n_sample, slab.n_slide, 1.0), t = 1.0 - r;
  const double sigma_s = slab.sigma_s_prime / (1.0 - slab.anisotropy);
  const std::array depth{(slab.sigma_a + sigma_s) * slab.thickness};
  forward::BeamColumn beam(r);
  beam.set(depth);
  return {r + t * beam.leaves_near(), t * beam.leaves_far(), 0.0, 0.0};
}

OpticalSlab optical(const MeasuredSlab& m) {
  return {m.n_sample, m.n_slide, m.thickness, m.sigma_a, m.sigma_s_prime, m.anisotropy};
}

SlabPrediction measured_by(const MeasuredSlab& m, const OpticalSlab& slab, const SlabTotals& total,
                           const SlabTotals& diffuse) {
  if (m.spheres != 1) {
    return {total.reflected, total.transmitted, total.reflected_error, total.transmitted_error};
  }
  const SlabTotals beam = unscattered(slab);
  const Sphere& r = m.reflection;
  const Sphere& t = m.transmission;
  const double third = t.third_port > 0.0 ? m.transmission_standard : t.wall_reflectance;
  const double gain_r = r.gain(diffuse.reflected, 0.0) / r.gain(m.standard, 0.0);
  const double gain_t = t.gain(diffuse.reflected, third) / t.gain(0.0, third);
  const double scattered_r = gain_r * r.first_bounce(0.0);
  const double scattered_t = gain_t * t.first_bounce(third);
  SlabPrediction seen;
  seen.reflectance = scattered_r * (total.reflected - beam.reflected) +
                     gain_r * r.wall_reflectance * beam.reflected;
  seen.transmittance =
      scattered_t * (total.transmitted - beam.transmitted) + gain_t * third * beam.transmitted;
  // The gain's own noise, R_d being traced apart.
  const double noisy = diffuse.reflected + diffuse.reflected_error;
  const double noise_r = r.gain(noisy, 0.0) / r.gain(diffuse.reflected, 0.0) - 1.0;
  const double noise_t = t.gain(noisy, third) / t.gain(diffuse.reflected, third) - 1.0;
  seen.reflectance_error =
      std::hypot(scattered_r * total.reflected_error, seen.reflectance * noise_r);
  seen.transmittance_error =
      std::hypot(scattered_t * total.transmitted_error, seen.transmittance * noise_t);
  return seen;
}

Json to_json(const SlabPrediction& p) {
  return {{"M_R", p.reflectance},
          {"M_T", p.transmittance},
          {"M_R_standard_error", p.reflectance_error},
          {"M_T_standard_error", p.transmittance_error}};
}

std::vector<std::string> files_of(const std::vector<SlabComparison>& rows) {
  std::vector<std::string> files;
  for (const SlabComparison& row : rows) {
    if (files.empty() || files.back() != row.measured.file) files.push_back(row.measured.file);
  }
  return files;
}

}  // namespace

SlabTotals diffuse_slab(const OpticalSlab& slab, Incidence incidence) {
  const BoundaryConstants constants = forward::slide_constants(slab.n_sample, slab.n_slide);
  const double extinction = slab.sigma_a + slab.sigma_s_prime;
  const std::vector<forward::Layer> layer{{1.0 / (3.0 * extinction), slab.sigma_a, slab.thickness}};
  SlabTotals totals;
  if (incidence == Incidence::diffuse) {
    const double specular = diffuse_surface_reflectance(slab);
    const double entering = 1.0 - specular;
    const double q = entering * constants.q_per_entering();
    const forward::LayeredMode mode(layer, constants.A, {0.0, 0.0, q});
    totals.reflected = specular + entering + mode.flux_out_near();
    totals.transmitted = mode.flux_out_far();
    return totals;
  }
  const double t = constants.normal_transmittance, r = 1.0 - t;
  const forward::LayeredMode mode(layer, constants.A, {0.0, t, 0.0, r});
  totals.reflected = r + mode.unscattered_near() + mode.flux_out_near();
  totals.transmitted = mode.unscattered_far() + mode.flux_out_far();
  return totals;
}

SlabPrediction slab_by_diffusion(const MeasuredSlab& m) {
  const OpticalSlab slab = optical(m);
  return measured_by(m, slab, diffuse_slab(slab, Incidence::normal),
                     m.spheres == 1 ? diffuse_slab(slab, Incidence::diffuse) : SlabTotals{});
}

SlabPrediction slab_by_photons(const MeasuredSlab& m, std::uint64_t photons, std::uint64_t seed) {
  const OpticalSlab slab = optical(m);
  return measured_by(
      m, slab, trace_slab(slab, Incidence::normal, photons, seed),
      m.spheres == 1 ? trace_slab(slab, Incidence::diffuse, photons, seed + 1) : SlabTotals{});
}

std::vector<SlabComparison> compare_slabs(const std::vector<MeasuredSlab>& slabs,
                                          const SlabOptions& options, Progress& progress) {
  std::map<std::string, std::size_t> count, seen;
  for (const MeasuredSlab& slab : slabs) ++count[slab.file];
  std::vector<SlabComparison> rows;
  for (std::size_t i = 0; i < slabs.size(); ++i) {
    const MeasuredSlab& m = slabs[i];
    const auto step =
        count[m.file] > options.spectrum ? static_cast<std::size_t>(options.every) : 1;
    if (seen[m.file]++ % step != 0) continue;
    progress.update("slabs", static_cast<double>(i) / static_cast<double>(slabs.size()),
                    m.file + " " + m.row);
    const std::uint64_t seed = options.seed + 2 * i;
    SlabComparison row;
    row.measured = m;
    row.diffusion = slab_by_diffusion(m);
    row.monte_carlo = slab_by_photons(m, options.photons, seed);
    if (options.fit) {
      row.fitted_by_diffusion = fit_by_diffusion(m);
      row.fitted_by_transport =
          fit_by_transport(m, row.fitted_by_diffusion, sphere_error, options.photons, seed);
    }
    rows.push_back(row);
  }
  return rows;
}

namespace {

Json to_json(const SlabCoefficients& found, const MeasuredSlab& m) {
  return {{"sigma_a over published", found.sigma_a / m.sigma_a},
          {"sigma_s' over published", found.sigma_s_prime / m.sigma_s_prime},
          {"log_sigma_a_std", found.log_sigma_a_std},
          {"log_sigma_s_std", found.log_sigma_s_std},
          {"refreshes", found.refreshes},
          {"settled", found.settled}};
}

Json to_json(const SlabComparison& row, bool fitted) {
  const MeasuredSlab& m = row.measured;
  Json fits;
  if (fitted) {
    fits = {{"diffusion", to_json(row.fitted_by_diffusion, m)},
            {"transport", to_json(row.fitted_by_transport, m)}};
  }
  return {{"fitted", fits},
          {"file", m.file},
          {"row", m.row},
          {"albedo", m.albedo()},
          {"mean_free_paths", m.mean_free_paths()},
          {"measured", {{"M_R", m.reflectance}, {"M_T", m.transmittance}}},
          {"diffusion", to_json(row.diffusion)},
          {"monte_carlo", to_json(row.monte_carlo)}};
}

/// Ranges and median absolute differences over the slabs of one file.
Json summary_of(const std::string& file, const Json& slabs) {
  std::vector<double> albedo, paths;
  std::map<std::string, std::vector<double>> differences;
  for (const Json& slab : slabs) {
    if (slab.at("file") != file) continue;
    albedo.push_back(slab.at("albedo"));
    paths.push_back(slab.at("mean_free_paths"));
    for (const char* model : {"diffusion", "monte_carlo"}) {
      for (const char* what : {"M_R", "M_T"}) {
        differences[std::string(model) + " " + what].push_back(std::abs(
            slab.at(model).at(what).get<double>() - slab.at("measured").at(what).get<double>()));
      }
    }
  }
  const auto [dark, bright] = std::minmax_element(albedo.begin(), albedo.end());
  const auto [thin, thick] = std::minmax_element(paths.begin(), paths.end());
  Json row{{"file", file},         {"rows", albedo.size()},         {"albedo from", *dark},
           {"albedo to", *bright}, {"mean free paths from", *thin}, {"to", *thick}};
  for (const auto& [name, values] : differences) row[name] = median(values);
  return row;
}

void measure_slabs(const Request& request, Progress& progress, const Save& save) {
  if (!request.has("data")) {
    throw InputError("--data is missing; name the folder with peer_iad.csv and its .rxt files.");
  }
  SlabOptions options;
  options.seed = request.seed;
  const bool quick = request.size == Size::quick;
  options.photons =
      static_cast<std::uint64_t>(request.number("photons", quick ? 1000 : options.photons));
  options.fit = request.has("fit");
  options.every = request.count("every", quick ? 60 : options.every);
  const auto compared =
      compare_slabs(read_measured_slabs(request.words("data").at(0)), options, progress);
  Json slabs = Json::array(), rows = Json::array();
  for (const SlabComparison& row : compared) slabs.push_back(to_json(row, options.fit));
  for (const std::string& file : files_of(compared)) rows.push_back(summary_of(file, slabs));
  save({{"photons", options.photons}, {"rows", rows}, {"slabs", slabs}});
}

}  // namespace

Subject slabs_subject() {
  return {"slabs",
          "Totals of measured slabs predicted by diffusion and by Monte Carlo (docs/validity.md)",
          R"(  kappamu-studies slabs --data ../shared/data/slab-rt-iad -o out/

From coefficients that inverse adding-doubling found: median |predicted - measured| of
total reflectance M_R and transmittance M_T, by file. The folder holds peer_iad.csv and
the .rxt files of github.com/scottprahl/iad it was made from.)",
          {{"slabs", "all files", measure_slabs}},
          {{"data", "Folder of the measurements", Setting::Kind::words},
           {"photons", "Per row (default 100000)", Setting::Kind::number, 100, 1e8},
           {"fit", "Coefficients too, by diffusion and by transport: ten times the time",
            Setting::Kind::flag},
           {"every", "Of long spectra, one row in so many (default 1: all)", Setting::Kind::number,
            1}}};
}

}  // namespace kappamu::studies
