#include "bench/validity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bench/chart.h"
#include "bench/record.h"
#include "forward/forward_model.h"
#include "forward/montecarlo/monte_carlo_model.h"

namespace kappamu::bench {

namespace {

using forward::ForwardProblem;
using forward::ForwardResult;
using Json = nlohmann::ordered_json;

constexpr int pixels_thick = 8, pixels_wide = 24;
constexpr std::size_t lit = 4, far = 5;  // z-, z+ in all_faces

ForwardProblem problem_of(double albedo, double mean_free_paths) {
  ForwardProblem problem;
  problem.setup.sides = Sides::mirror;
  problem.setup.shape = {pixels_wide, pixels_wide, pixels_thick, mean_free_paths / pixels_thick};
  const GridShape& s = problem.setup.shape;
  problem.medium = {Volume<double>(s, 1.0 / 3.0), Volume<double>(s, 1.0 - albedo)};
  constexpr int first = (pixels_wide - pixels_thick) / 2, last = first + pixels_thick;
  for (int y = 0; y < pixels_wide; ++y) {
    for (int x = 0; x < pixels_wide; ++x) {
      const bool bright = x >= first && x < last && y >= first && y < last;
      problem.irradiance.push_back(bright ? 1.0 : 0.0);
    }
  }
  return problem;
}

RelativeError total_error(const ForwardResult& diffusion, const ForwardResult& transport,
                          std::size_t face, const ForwardProblem& problem, std::uint64_t photons) {
  const double theirs = transport.balance[0].exiting[face];
  if (theirs <= 0.0) return {0.0, 1.0};
  const double h = problem.setup.shape.voxel_mm;
  const auto& map = transport.exitance[face];
  const double noise =
      forward::standard_error_of_mean(map, transport.standard_error[face],
                                      transport.balance[0].entering, h * h, photons) *
      static_cast<double>(map.size()) * h * h / theirs;
  const double ratio = diffusion.balance[0].exiting[face] / theirs;
  return {ratio - 1.0, noise * ratio};
}

/// The expected square of the noise is taken off the square of the difference. That square's own
/// variance is Σ 4d²σ² + 2σ⁴ over the pixels, d the error proper.
RelativeError map_error(const ForwardResult& diffusion, const ForwardResult& transport,
                        std::size_t face) {
  double square = 0.0, variance = 0.0, norm = 0.0;
  for (std::size_t k = 0; k < transport.exitance[face].size(); ++k) {
    const double theirs = transport.exitance[face][k];
    const double noise = std::pow(transport.standard_error[face][k], 2);
    const double difference = std::pow(diffusion.exitance[face][k] - theirs, 2);
    square += difference - noise;
    variance += 4.0 * std::max(0.0, difference - noise) * noise + 2.0 * noise * noise;
    norm += theirs * theirs;
  }
  if (norm <= 0.0) return {0.0, 1.0};
  const double value = std::max(0.0, square) / norm, error = std::sqrt(variance) / norm;
  return {std::sqrt(value), value > error ? error / (2.0 * std::sqrt(value)) : std::sqrt(error)};
}

struct Band {
  double below;  ///< |error|
  const char* colour;
  const char* label;
};
// From blue to red, told apart in grey and by the colour-blind; grey where nothing was resolved.
constexpr std::array<Band, 4> bands{{{0.01, "0x4393C3", "below 1 %"},
                                     {0.03, "0xA6D3E8", "1 to 3 %"},
                                     {0.1, "0xFDDBA0", "3 to 10 %"},
                                     {HUGE_VAL, "0xE08060", "above 10 %"}}};
constexpr Band unresolved{0.0, "0xDDDDDD", "below the noise of Monte Carlo"};

struct Panel {
  const char* title;
  RelativeError ValidityCase::*error;
  const char* format;
};
constexpr std::array<Panel, 4> panels{
    {{"reflected total, diffusion / Monte Carlo - 1 [%]", &ValidityCase::reflected, "%+.1f"},
     {"transmitted total, diffusion / Monte Carlo - 1 [%]", &ValidityCase::transmitted, "%+.1f"},
     {"lit face under a patch, relative L2 error [%]", &ValidityCase::lit_map, "%.1f"},
     {"far face under a patch, relative L2 error [%]", &ValidityCase::far_map, "%.1f"}}};

/// Positions of the values met, in order of first appearance, as a list of tics.
std::string tics_of(const std::vector<double>& values) {
  std::ostringstream text;
  for (std::size_t i = 0; i < values.size(); ++i) {
    text << (i ? ", " : "(") << '"' << values[i] << "\" " << i;
  }
  return text.str() + ")";
}

std::size_t position(std::vector<double>& values, double value) {
  const auto found = std::find(values.begin(), values.end(), value);
  if (found != values.end()) return static_cast<std::size_t>(found - values.begin());
  values.push_back(value);
  return values.size() - 1;
}

void write_panel(const std::vector<ValidityCase>& cases, std::size_t number, std::ostream& out) {
  const Panel& panel = panels[number];
  std::vector<double> thicknesses, albedos;
  out << "$panel" << number << " << END\n";
  for (const ValidityCase& c : cases) {
    const RelativeError& e = c.*panel.error;
    const Band* band = &unresolved;
    if (e.resolved()) {
      band = std::find_if(bands.begin(), bands.end(),
                          [&](const Band& b) { return std::abs(e.value) < b.below; });
    }
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), panel.format, 100.0 * e.value);
    out << position(thicknesses, c.mean_free_paths) << ' ' << position(albedos, c.albedo) << ' '
        << band->colour << ' ' << (e.resolved() ? text.data() : "-") << '\n';
  }
  out << "END\nset title \"" << panel.title << "\" font \",12\"\n"
      << "set xtics " << tics_of(thicknesses) << "\nset ytics " << tics_of(albedos) << '\n'
      << "set xrange [-0.5:" << static_cast<double>(thicknesses.size()) - 0.5
      << "]\nset yrange [-0.5:" << static_cast<double>(albedos.size()) - 0.5 << "]\n"
      << "plot $panel" << number
      << " using 1:2:(0.49):(0.48):3 with boxxyerror fs solid noborder fc rgb variable notitle, "
         "\\\n"
      << "     $panel" << number << " using 1:2:4 with labels font \",10\" notitle\n";
}

}  // namespace

bool RelativeError::resolved() const {
  return standard_error < std::max(0.005, std::abs(value) / 3.0);
}

ValidityOptions quick_validity() {
  ValidityOptions options;
  options.albedos = {0.7, 0.9, 0.99};
  options.thicknesses = {2, 8, 32};
  options.photons = 100'000;
  return options;
}

std::vector<ValidityCase> measure_validity(const ValidityOptions& options, Progress& progress) {
  const auto analytic = forward::make_forward_model("analytic");
  const auto monte_carlo = forward::make_forward_model("montecarlo");
  forward::ForwardOptions settings;
  settings.device = options.device;
  settings.photons = options.photons;
  std::vector<ValidityCase> cases;
  const std::size_t count = options.albedos.size() * options.thicknesses.size();
  Progress silent;
  for (const double albedo : options.albedos) {
    for (const double paths : options.thicknesses) {
      std::ostringstream detail;
      detail << "albedo " << albedo << ", " << paths << " mean free paths";
      progress.update("validity", static_cast<double>(cases.size()) / static_cast<double>(count),
                      detail.str());
      const ForwardProblem problem = problem_of(albedo, paths);
      settings.seed = options.seed + cases.size();  // no two cases share their noise
      const ForwardResult ours = analytic->solve(problem, settings, silent);
      const ForwardResult theirs = monte_carlo->solve(problem, settings, silent);
      ValidityCase one;
      one.albedo = albedo;
      one.mean_free_paths = paths;
      one.reflected = total_error(ours, theirs, lit, problem, options.photons);
      one.transmitted = total_error(ours, theirs, far, problem, options.photons);
      one.lit_map = map_error(ours, theirs, lit);
      one.far_map = map_error(ours, theirs, far);
      const double incident = paths * paths;  // irradiance 1 on the patch
      one.reflectance = theirs.balance[0].exiting[lit] / incident;
      one.transmittance = theirs.balance[0].exiting[far] / incident;
      cases.push_back(one);
    }
  }
  return cases;
}

Json validity_record(const ValidityOptions& options, const std::vector<ValidityCase>& cases) {
  Json record = record_header("validity", options.device);
  record["photons"] = options.photons;
  record["seed"] = options.seed;
  record["eta"] = 1.3;
  Json& list = record["cases"] = Json::array();
  const auto error = [](const RelativeError& e) {
    return Json{
        {"error", e.value}, {"standard_error", e.standard_error}, {"resolved", e.resolved()}};
  };
  for (const ValidityCase& c : cases) {
    list.push_back({{"albedo", c.albedo},
                    {"mean_free_paths", c.mean_free_paths},
                    {"reflectance", c.reflectance},
                    {"transmittance", c.transmittance},
                    {"reflected", error(c.reflected)},
                    {"transmitted", error(c.transmitted)},
                    {"lit_map", error(c.lit_map)},
                    {"far_map", error(c.far_map)}});
  }
  return record;
}

void draw_validity(const std::vector<ValidityCase>& cases, const std::filesystem::path& png) {
  render(png, [&](const std::string& output) {
    std::ostringstream text;
    text << "set encoding utf8\nset terminal pngcairo size 1180,900 enhanced font \"DejaVu "
            "Sans,11\"\n"
         << "set output " << output << "\n"
         << "set multiplot layout 2,2 margins 0.065,0.985,0.12,0.955 spacing 0.075,0.12\n"
         << "set tics nomirror scale 0\nset border lw 1\nunset key\n"
         << "set xlabel \"thickness [transport mean free paths]\"\n"
         << "set ylabel \"albedo {/Symbol s}_s' / ({/Symbol s}_s' + {/Symbol m})\" offset 1\n";
    double left = 0.08;
    int object = 0;
    const auto legend = [&](const Band& band) {
      ++object;
      text << "set object " << object << " rectangle from screen " << left << ",0.02 to screen "
           << left + 0.022 << ",0.042 fc rgb " << band.colour << " fs solid noborder\n"
           << "set label " << object << " \"" << band.label << "\" at screen " << left + 0.028
           << ",0.031\n";
      left += 0.15;
    };
    for (const Band& band : bands) legend(band);
    legend(unresolved);
    for (std::size_t i = 0; i < panels.size(); ++i) {
      write_panel(cases, i, text);
      if (i == 0) text << "unset object\nunset label\n";
    }
    text << "unset multiplot\n";
    return text.str();
  });
}

std::string validity_table(const ValidityOptions& options, const std::vector<ValidityCase>& cases) {
  std::ostringstream out;
  out << "// Written by `kappamu bench validity`: do not edit. Errors of diffusion against "
         "transport, relative;\n// {} where Monte Carlo does not resolve them.\n"
      << "constexpr std::array<double, " << options.albedos.size() << "> table_albedo{";
  const auto list = [&](const std::vector<double>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) out << (i ? ", " : "") << values[i];
    out << "};\n";
  };
  list(options.albedos);
  out << "constexpr std::array<double, " << options.thicknesses.size() << "> table_thickness{";
  list(options.thicknesses);
  out << "// reflected, transmitted, far_map of [albedo][thickness]\n"
      << "constexpr std::array<ValidityEstimate, " << cases.size() << "> table_error{{\n";
  out.precision(3);
  const auto value = [&](const RelativeError& e) {
    if (!e.resolved()) return std::string("{}");
    std::ostringstream text;
    text.precision(3);
    text << e.value;
    return text.str();
  };
  for (const ValidityCase& c : cases) {
    out << "    {" << value(c.reflected) << ", " << value(c.transmitted) << ", " << value(c.far_map)
        << "},\n";
  }
  out << "}};\n";
  return out.str();
}

}  // namespace kappamu::bench
