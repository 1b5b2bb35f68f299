#include "bench/slabs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/chart.h"
#include "bench/record.h"
#include "forward/analytic/layered_mode.h"

namespace kappamu::bench {

namespace {

using Json = nlohmann::ordered_json;

/// ∫₀¹ f dc by the midpoint rule: slides have corners at two critical angles, and 1e-6 is enough.
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
    return 2.0 * c * slide_reflectance(slab.n_sample, slab.n_slide, inside);
  });
}

/// Specular and unscattered light, exact whatever the model of the rest: a beam going to and fro.
SlabTotals unscattered(const OpticalSlab& slab) {
  const double r = slide_reflectance(slab.n_sample, slab.n_slide, 1.0), t = 1.0 - r;
  const double sigma_s = slab.sigma_s_prime / (1.0 - slab.anisotropy);
  const double pass = std::exp(-(slab.sigma_a + sigma_s) * slab.thickness);
  const double down = t / (1.0 - r * r * pass * pass);
  return {r + down * pass * r * pass * t, down * pass * t, 0.0, 0.0};
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

/// What a file of the published set measures, before its name; other files go by their name.
std::string label_of(const std::string& file) {
  static const std::map<std::string, std::string> materials{
      {"510nm_phantom", "phantom"}, {"il_A", "Intralipid"}, {"ink_A", "ink"},
      {"kenlee_A", "TiO2"},         {"royston1", "ink"},    {"tio2_vis", "TiO2 phantom"}};
  std::string name = file;
  std::replace(name.begin(), name.end(), '_', ' ');
  const auto known = materials.find(file);
  return known == materials.end() ? name : known->second + " (" + name + ")";
}

}  // namespace

BoundaryConstants slide_constants(double n_sample, double n_slide) {
  const auto moment = [&](int power) {
    return mean([&](double c) {
      return (power + 1) * std::pow(c, power) * slide_reflectance(n_sample, n_slide, c);
    });
  };
  BoundaryConstants constants;
  constants.eta = n_sample;
  constants.r_phi = moment(1);
  constants.r_j = moment(2);
  constants.A = (1.0 + constants.r_j) / (1.0 - constants.r_phi);
  constants.normal_transmittance = 1.0 - slide_reflectance(n_sample, n_slide, 1.0);
  return constants;
}

SlabTotals diffuse_slab(const OpticalSlab& slab, Incidence incidence) {
  const BoundaryConstants constants = slide_constants(slab.n_sample, slab.n_slide);
  const double extinction = slab.sigma_a + slab.sigma_s_prime;
  const std::vector<forward::Layer> layer{{1.0 / (3.0 * extinction), slab.sigma_a, slab.thickness}};
  SlabTotals totals;
  if (incidence == Incidence::diffuse) {
    const double specular = diffuse_surface_reflectance(slab);
    const double entering = 1.0 - specular;
    const double q = 4.0 * entering / (1.0 - constants.r_phi);
    const forward::LayeredMode mode(layer, constants.A, {0.0, 0.0, q});
    totals.reflected = specular + entering + mode.flux_out_near();
    totals.transmitted = mode.flux_out_far();
    return totals;
  }
  const forward::LayeredMode mode(layer, constants.A, {0.0, 1.0, 0.0});
  // The beam goes to and fro between the surfaces: geometric series of what each pass leaves.
  const double t = constants.normal_transmittance, r = 1.0 - t;
  const double pass = std::exp(-extinction * slab.thickness);
  const double down = t / (1.0 - r * r * pass * pass), up = down * pass * r;
  const double near = mode.flux_out_near(), far = mode.flux_out_far();
  totals.reflected = r + up * pass * t + down * near + up * far;
  totals.transmitted = down * pass * t + down * far + up * near;
  return totals;
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
    OpticalSlab slab{m.n_sample, m.n_slide, m.thickness, m.sigma_a, m.sigma_s_prime, m.anisotropy};
    const std::uint64_t seed = options.seed + 2 * i;
    SlabComparison row;
    row.measured = m;
    const bool sphere = m.spheres == 1;
    row.diffusion = measured_by(m, slab, diffuse_slab(slab, Incidence::normal),
                                sphere ? diffuse_slab(slab, Incidence::diffuse) : SlabTotals{});
    row.monte_carlo = measured_by(
        m, slab, trace_slab(slab, Incidence::normal, options.photons, seed),
        sphere ? trace_slab(slab, Incidence::diffuse, options.photons, seed + 1) : SlabTotals{});
    rows.push_back(row);
  }
  return rows;
}

std::vector<SlabSummary> summarise(const std::vector<SlabComparison>& rows) {
  std::vector<SlabSummary> list;
  for (const std::string& file : files_of(rows)) {
    SlabSummary s;
    s.file = file;
    s.albedo_low = 1.0;
    s.paths_low = HUGE_VAL;
    std::vector<double> dr, dt, mr, mt;
    for (const SlabComparison& row : rows) {
      const MeasuredSlab& m = row.measured;
      if (m.file != file) continue;
      ++s.rows;
      s.albedo_low = std::min(s.albedo_low, m.albedo());
      s.albedo_high = std::max(s.albedo_high, m.albedo());
      s.paths_low = std::min(s.paths_low, m.mean_free_paths());
      s.paths_high = std::max(s.paths_high, m.mean_free_paths());
      dr.push_back(std::abs(row.diffusion.reflectance - m.reflectance));
      dt.push_back(std::abs(row.diffusion.transmittance - m.transmittance));
      mr.push_back(std::abs(row.monte_carlo.reflectance - m.reflectance));
      mt.push_back(std::abs(row.monte_carlo.transmittance - m.transmittance));
    }
    s.diffusion_r = median(dr);
    s.diffusion_t = median(dt);
    s.monte_carlo_r = median(mr);
    s.monte_carlo_t = median(mt);
    list.push_back(s);
  }
  return list;
}

Json slab_record(const SlabOptions& options, const std::vector<SlabComparison>& rows) {
  Json record = record_header("slabs", "host");
  record["photons"] = options.photons;
  record["seed"] = options.seed;
  record["summary"] = Json::array();
  for (const SlabSummary& s : summarise(rows)) {
    record["summary"].push_back(
        {{"file", s.file},
         {"rows", s.rows},
         {"albedo", {s.albedo_low, s.albedo_high}},
         {"mean_free_paths", {s.paths_low, s.paths_high}},
         {"median_absolute_difference",
          {{"diffusion", {{"M_R", s.diffusion_r}, {"M_T", s.diffusion_t}}},
           {"monte_carlo", {{"M_R", s.monte_carlo_r}, {"M_T", s.monte_carlo_t}}}}}});
  }
  record["rows"] = Json::array();
  for (const SlabComparison& row : rows) {
    const MeasuredSlab& m = row.measured;
    record["rows"].push_back({{"file", m.file},
                              {"row", m.row},
                              {"albedo", m.albedo()},
                              {"mean_free_paths", m.mean_free_paths()},
                              {"measured", {{"M_R", m.reflectance}, {"M_T", m.transmittance}}},
                              {"diffusion", to_json(row.diffusion)},
                              {"monte_carlo", to_json(row.monte_carlo)}});
  }
  return record;
}

void draw_slabs(const std::vector<SlabComparison>& rows, const std::filesystem::path& png) {
  const std::vector<std::string> files = files_of(rows);
  const auto scatter = [&](const std::string& title, SlabPrediction SlabComparison::*model,
                           double SlabPrediction::*predicted, double MeasuredSlab::*measured) {
    Chart chart;
    chart.title = title;
    chart.x_label = "measured, share of incident light";
    chart.y_label = "predicted";
    chart.x_range = chart.y_range = {0.0, 0.9};
    chart.legend = "inside left top";
    for (std::size_t f = 0; f < files.size(); ++f) {
      Series series;
      series.label = label_of(files[f]);
      series.style = Series::Style::points;
      series.colour = static_cast<int>(f) + 1;
      for (const SlabComparison& row : rows) {
        if (row.measured.file != files[f]) continue;
        series.x.push_back(row.measured.*measured);
        series.y.push_back(row.*model.*predicted);
      }
      chart.series.push_back(series);
    }
    chart.series.push_back({"equal", {0.0, 0.9}, {0.0, 0.9}, {}, Series::Style::line, 10});
    return chart;
  };
  const auto against_albedo = [&](const std::string& title, double SlabPrediction::*predicted,
                                  double MeasuredSlab::*measured) {
    Chart chart;
    chart.title = title;
    chart.x_label = "absorbed share of collisions, 1 - albedo";
    chart.y_label = "predicted - measured";
    chart.log_x = true;
    chart.x_range = {5e-4, 1.2};
    chart.legend = "inside left top";
    const auto add = [&](const std::string& label, SlabPrediction SlabComparison::*model,
                         int colour) {
      Series series;
      series.label = label;
      series.style = Series::Style::points;
      series.colour = colour;
      for (const SlabComparison& row : rows) {
        series.x.push_back(1.0 - row.measured.albedo());
        series.y.push_back(row.*model.*predicted - row.measured.*measured);
      }
      chart.series.push_back(series);
    };
    add("Monte Carlo", &SlabComparison::monte_carlo, 1);
    add("diffusion", &SlabComparison::diffusion, 2);  // in front
    return chart;
  };
  const std::vector<Chart> charts{
      scatter("total reflectance by diffusion", &SlabComparison::diffusion,
              &SlabPrediction::reflectance, &MeasuredSlab::reflectance),
      scatter("total transmittance by diffusion", &SlabComparison::diffusion,
              &SlabPrediction::transmittance, &MeasuredSlab::transmittance),
      scatter("total reflectance by Monte Carlo", &SlabComparison::monte_carlo,
              &SlabPrediction::reflectance, &MeasuredSlab::reflectance),
      scatter("total transmittance by Monte Carlo", &SlabComparison::monte_carlo,
              &SlabPrediction::transmittance, &MeasuredSlab::transmittance),
      against_albedo("reflectance: where diffusion holds", &SlabPrediction::reflectance,
                     &MeasuredSlab::reflectance),
      against_albedo("transmittance: where diffusion holds", &SlabPrediction::transmittance,
                     &MeasuredSlab::transmittance)};
  draw(charts, png, 2, 640, 440);
}

}  // namespace kappamu::bench
