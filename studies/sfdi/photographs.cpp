#include "studies/sfdi/photographs.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/optics.h"
#include "core/processor_time.h"
#include "forward/lateral/lateral_diffusion.h"
#include "forward/lateral/lateral_reflectance.h"
#include "io/csv_table.h"
#include "io/image/image_file.h"
#include "pipeline/sfdi/sfdi_map.h"

namespace kappamu::studies::sfdi {

namespace {

namespace fs = std::filesystem;
namespace map = pipeline::sfdi;

// Of the photographs (their SOURCE.md): scale, frequency, channel, the disc that phantoms fill, the
// instrument's errors that pixels share. n and g are silicone's and usual.
constexpr double pixel_mm = 0.2825, frequency = 0.2, wavelength = 660.0, index = 1.4,
                 anisotropy = 0.9;
constexpr double codes_per_reflectance = 279.7;
constexpr std::array<int, 4> disc{66, 75, 127, 111}, whole{0, 0, 256, 256};
constexpr double published_mua_per_code = 0.25 / 255.0, published_musp_per_code = 2.5 / 255.0;

fs::path data_of(const Request& request) {
  if (!request.has("data")) {
    throw InputError("--data is missing; name the folder of the photographs.");
  }
  return request.words("data").at(0);
}

struct Phantom {
  std::string name;
  double mua = 0.0, musp = 0.0;  ///< published [1/mm]
};

std::vector<Phantom> read_phantoms(const fs::path& data) {
  std::vector<Phantom> phantoms;
  io::read_csv(data / "phantoms.csv", {{"phantom"}, {"mua_per_mm"}, {"musp_per_mm"}},
               [&](const std::vector<std::string>& cells, const std::string&) {
                 phantoms.push_back({cells[0], io::csv_number(cells[1]).value(),
                                     io::csv_number(cells[2]).value()});
               });
  return phantoms;
}

/// A sample with a phantom as reference; null: on the photographs' absolute scale.
map::Description describe(const fs::path& data, const Phantom* reference) {
  map::Description d;
  d.folder = data;
  d.pixel_mm = pixel_mm;
  d.channel = "G";
  d.crop_px = whole;
  d.medium = {index, 0.02, anisotropy, 0.05, {}, {}, {}, {}};
  d.errors = {0.002, 0.005};
  if (reference != nullptr) {
    d.reference = {{{wavelength, reference->mua, reference->musp, {}}}, disc, {}};
  } else {
    d.codes_per_reflectance = codes_per_reflectance;
  }
  return d;
}

map::Pictures pictures(double per_mm, const std::string& sample, const Phantom* reference) {
  map::Pictures p;
  p.wavelength_nm = wavelength;
  p.per_mm = per_mm;
  p.sample = {sample};
  if (reference != nullptr && per_mm > 0.0) p.reference = {"phantoms/" + reference->name + ".png"};
  return p;
}

double error_of(double measured, double published) {
  return measured / published - 1.0;
}

struct Coverage {
  int inside = 0, all = 0;
  void add(double measured, double published, double deviation) {
    inside += std::abs(measured - published) <= 2.0 * deviation ? 1 : 0;
    ++all;
  }
  double share() const { return static_cast<double>(inside) / all; }
};

double median_size(std::vector<double> errors) {
  for (double& error : errors) error = std::abs(error);
  return median(errors);
}

double largest_size(const std::vector<double>& errors) {
  double largest = 0.0;
  for (const double error : errors) largest = std::max(largest, std::abs(error));
  return largest;
}

/// Errors of one coefficient over pairs, by phantom.
struct Errors {
  std::vector<double> all, by_phantom;
  Coverage covered;
  void end_phantom(const std::vector<double>& errors) {
    all.insert(all.end(), errors.begin(), errors.end());
    by_phantom.push_back(median_size(errors));
  }
  Json json() const {
    return {{"median", median_size(all)},
            {"worst_phantom", largest_size(by_phantom)},
            {"worst_pair", largest_size(all)},
            {"within_two_deviations", covered.share()}};
  }
};

/// Diffusion's reflectance per light that enters.
double diffusion(double f, double mua, double musp) {
  static const double robin_A = boundary_constants(index).A;
  return forward::diffuse_half_space(mua / musp, 2.0 * std::numbers::pi * f / musp, robin_A);
}

/// σs' of phantoms with the same scatterer and different ink: largest difference from their mean,
/// measured on the absolute scale and published.
Json equal_scatterer(const Json& absolute, const std::vector<Phantom>& phantoms) {
  Json groups = Json::array();
  for (const std::vector<std::string>& group :
       {std::vector<std::string>{"ph3", "ph11", "ph14"}, {"ph2", "ph5", "ph10"}}) {
    std::vector<double> measured, published;
    for (std::size_t i = 0; i < phantoms.size(); ++i) {
      if (std::find(group.begin(), group.end(), phantoms[i].name) == group.end()) continue;
      measured.push_back(absolute[i].at("musp").get<double>());
      published.push_back(phantoms[i].musp);
    }
    const auto spread = [](const std::vector<double>& values) {
      double mean = 0.0, largest = 0.0;
      for (const double value : values) mean += value / static_cast<double>(values.size());
      for (const double value : values) largest = std::max(largest, std::abs(value / mean - 1.0));
      return largest;
    };
    groups.push_back(
        {{"phantoms", group}, {"measured", spread(measured)}, {"published", spread(published)}});
  }
  return groups;
}

}  // namespace

void measure_peer(const Request& request, Progress&, const Save& save) {
  const forward::LateralReflectance transport({index, anisotropy, {}});
  Json rows = Json::array();
  double largest = 0.0, largest_diffusion = 0.0;
  io::read_csv(data_of(request) / "peer_rd.csv",
               {{"f_per_mm"},
                {"mua_per_mm"},
                {"musp_per_mm"},
                {"rd0_mc_g0.9"},
                {"rdf_mc_g0.9"},
                {"rdf_lut"}},
               [&](const std::vector<std::string>& cells, const std::string&) {
                 std::array<double, 6> v{};
                 for (std::size_t i = 0; i < v.size(); ++i) v[i] = io::csv_number(cells[i]).value();
                 const auto [f, mua, musp, even, wave, other] = v;
                 const double ours_even = transport(0.0, mua, musp).reflectance;
                 const double ours = transport(f, mua, musp).reflectance;
                 rows.push_back({{"f_per_mm", f},
                                 {"mua_per_mm", mua},
                                 {"musp_per_mm", musp},
                                 {"even", error_of(ours_even, even)},
                                 {"even diffusion", error_of(diffusion(0.0, mua, musp), even)},
                                 {"wave", error_of(ours, wave)},
                                 {"wave diffusion", error_of(diffusion(f, mua, musp), wave)},
                                 {"wave other group", error_of(other, wave)},
                                 {"our error", transport.relative_error(f, mua, musp)}});
                 if (f > 0.301) return;
                 for (const char* name : {"even", "wave"}) {
                   const Json& row = rows.back();
                   largest = std::max(largest, std::abs(row.at(name).get<double>()));
                   largest_diffusion =
                       std::max(largest_diffusion,
                                std::abs(row.at(std::string(name) + " diffusion").get<double>()));
                 }
               });
  // Cost of one reflectance with its derivatives.
  constexpr int evaluations = 200000;
  const auto nanoseconds = [&](const auto& one) {
    const double before = processor_seconds();
    [[maybe_unused]] volatile double kept = 0.0;
    for (int i = 0; i < evaluations; ++i) kept = one(0.01 + 1e-7 * i);
    return (processor_seconds() - before) * 1e9 / evaluations;
  };
  save({{"largest_up_to_0.3", largest},
        {"largest_up_to_0.3_diffusion", largest_diffusion},
        {"nanoseconds",
         nanoseconds([&](double mua) { return transport(frequency, mua, 1.0).reflectance; })},
        {"nanoseconds_diffusion",
         nanoseconds([&](double mua) { return diffusion(frequency, mua, 1.0); })},
        {"rows", rows}});
}

void measure_phantoms(const Request& request, Progress& progress, const Save& save) {
  const fs::path data = data_of(request);
  const std::vector<Phantom> phantoms = read_phantoms(data);
  Json pairs = Json::array(), rows = Json::array(), absolute = Json::array();
  Errors mua, musp, absolute_mua, absolute_musp;
  double slowest = 0.0;
  const auto measured = [&](const Phantom& sample, const Phantom* reference) {
    map::Description d = describe(data, reference);
    d.region_px = disc;
    d.measurements = {pictures(frequency, "phantoms/" + sample.name + ".png", reference)};
    Progress quiet;
    const Stopwatch watch;
    const map::Maps maps = map::measure_maps(d, quiet);
    slowest = std::max(slowest, watch.seconds());
    return *maps.wavelengths.front().region;
  };
  const auto add = [](const Phantom& sample, const map::RegionMean& r, std::vector<double>& a,
                      std::vector<double>& s, Errors& errors_a, Errors& errors_s) {
    a.push_back(error_of(r.mean.mua, sample.mua));
    s.push_back(error_of(r.mean.musp, sample.musp));
    errors_a.covered.add(r.mean.mua, sample.mua, r.deviation[0]);
    errors_s.covered.add(r.mean.musp, sample.musp, r.deviation[1]);
    return Json{{"mua", r.mean.mua},
                {"mua_error", a.back()},
                {"mua_deviation", r.deviation[0] / r.mean.mua},
                {"musp", r.mean.musp},
                {"musp_error", s.back()},
                {"musp_deviation", r.deviation[1] / r.mean.musp}};
  };
  for (std::size_t i = 0; i < phantoms.size(); ++i) {
    const Phantom& sample = phantoms[i];
    std::vector<double> a, s, absolute_a, absolute_s;
    for (const Phantom& reference : phantoms) {
      if (&reference == &sample) continue;
      progress.update("phantoms", static_cast<double>(i) / static_cast<double>(phantoms.size()),
                      sample.name + " by " + reference.name);
      Json pair{{"sample", sample.name}, {"reference", reference.name}};
      pair.update(add(sample, measured(sample, &reference), a, s, mua, musp));
      pairs.push_back(pair);
    }
    Json alone{{"sample", sample.name}};
    alone.update(add(sample, measured(sample, nullptr), absolute_a, absolute_s, absolute_mua,
                     absolute_musp));
    absolute.push_back(alone);
    mua.end_phantom(a);
    musp.end_phantom(s);
    absolute_mua.end_phantom(absolute_a);
    absolute_musp.end_phantom(absolute_s);
    rows.push_back({{"phantom", sample.name},
                    {"mua", sample.mua},
                    {"musp", sample.musp},
                    {"mua median error", median_size(a)},
                    {"mua worst", largest_size(a)},
                    {"musp median error", median_size(s)},
                    {"musp worst", largest_size(s)},
                    {"mua absolute", absolute_a.front()},
                    {"musp absolute", absolute_s.front()}});
  }
  save({{"mua", mua.json()},
        {"musp", musp.json()},
        {"absolute_mua", absolute_mua.json()},
        {"absolute_musp", absolute_musp.json()},
        {"equal_scatterer", equal_scatterer(absolute, phantoms)},
        {"slowest_seconds", slowest},
        {"rows", rows},
        {"pairs", pairs},
        {"absolute", absolute}});
}

void measure_tissue(const Request& request, Progress& progress, const Save& save) {
  const fs::path data = data_of(request);
  const std::vector<Phantom> phantoms = read_phantoms(data);
  Json rows = Json::array();
  for (const std::string tissue : {"pig1_2_4", "pig3_2_4"}) {
    const Image<std::uint16_t> published =
        io::read_code_image(data / "pig" / ("AC-" + tissue + ".png"));
    for (const bool even : {true, false}) {
      for (const Phantom& reference : phantoms) {
        progress.update("tissue", static_cast<double>(rows.size()) / 36.0, tissue);
        map::Description d = describe(data, &reference);
        if (even) {
          d.measurements.push_back(pictures(0.0, "pig/DC-" + tissue + ".png", &reference));
        }
        d.measurements.push_back(pictures(frequency, "pig/AC-" + tissue + ".png", &reference));
        Progress quiet;
        const Stopwatch watch;
        const map::Maps maps = map::measure_maps(d, quiet);
        const double seconds = watch.seconds();
        const map::WavelengthMap& m = maps.wavelengths.front();
        std::vector<double> a, s;
        Coverage covered_a, covered_s;
        for (int y = 0; y < whole[3]; ++y) {
          for (int x = 0; x < whole[2]; ++x) {
            const double mua = published_mua_per_code * published(whole[2] + x, y, 0);
            const double musp = published_musp_per_code * published(whole[2] + x, y, 1);
            if (m.verdict(x, y) != 0 || mua <= 0.0 || musp <= 0.0) continue;
            a.push_back(error_of(m.mua(x, y), mua));
            s.push_back(error_of(m.musp(x, y), musp));
            covered_a.add(m.mua(x, y), mua, m.mua_deviation(x, y));
            covered_s.add(m.musp(x, y), musp, m.musp_deviation(x, y));
          }
        }
        rows.push_back({{"tissue", tissue},
                        {"pictures", even ? "sinusoid and even light" : "sinusoid alone"},
                        {"reference", reference.name},
                        {"mua median error", median_size(a)},
                        {"mua bias", median(a)},
                        {"mua within 2 deviations", covered_a.share()},
                        {"musp median error", median_size(s)},
                        {"musp bias", median(s)},
                        {"musp within 2 deviations", covered_s.share()},
                        {"valid", static_cast<double>(a.size()) / m.verdict.size()},
                        {"seconds", seconds}});
        save({{"rows", rows}});
      }
    }
  }
}

}  // namespace kappamu::studies::sfdi
