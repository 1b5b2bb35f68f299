#include "studies/dipole/dipole_bench.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/processor_time.h"
#include "forward/dipole/form_factor/form_factor.h"
#include "studies/forward/slab_photons.h"
#include "studies/subjects.h"
#include "tests/cases/form_factor_case.h"
#include "tests/cases/form_factor_quadrature.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

using namespace forward;
using namespace forward::dipole;

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
}

double share_below(const std::vector<double>& values, double limit) {
  const auto below =
      std::count_if(values.begin(), values.end(), [&](double v) { return v < limit; });
  return static_cast<double>(below) / static_cast<double>(values.size());
}

}  // namespace

void dipole_form_factors(const Request& request, Progress& progress, const Save& save) {
  const int cases = request.size == Size::quick ? 40 : 2000;
  struct Method {
    std::string name;
    double ratio;
  };
  const std::vector<Method> methods{{"Taylor [T]", 0.4},
                                    {"Taylor [T]", 0.2},
                                    {"Taylor [T]", 0.1},
                                    {"Taylor [T]", 0.05},
                                    {"Gauss in asinh", 0.0}};
  std::vector<FormFactorCase> all;
  std::vector<Profile> profile;
  std::vector<double> exact;
  for (int i = 0; i < cases; ++i) {
    progress.update("bench dipole", 0.8 * i / cases, "form factors by quadrature");
    all.push_back(form_factor_case(request.seed + 1, static_cast<std::uint64_t>(i)));
    profile.push_back(make_profile("dipole", all.back().material, 1.3));
    exact.push_back(
        test_cases::quadrature_form_factor(profile.back(), all.back().triangle, all.back().point));
  }
  Json rows = Json::array();
  for (const Method& method : methods) {
    std::vector<double> relative, near, absolute;
    double samples = 0.0;
    const double start = processor_seconds();
    for (std::size_t i = 0; i < all.size(); ++i) {
      const FormFactorCase& c = all[i];
      const FormFactor f = method.ratio > 0.0
                               ? taylor_form_factor(profile[i], c.triangle, c.point, method.ratio)
                               : form_factor(profile[i], c.triangle, c.point);
      samples += f.samples;
      relative.push_back(std::abs(f.value / exact[i] - 1.0));
      absolute.push_back(std::abs(f.value - exact[i]) / profile[i].reflectance());
      // What a triangle of consequence sends, seen from where the paper's criterion can be met.
      if (exact[i] > 0.01 * profile[i].reflectance() && !c.on_edge) near.push_back(relative.back());
    }
    const double seconds = processor_seconds() - start;
    rows.push_back({{"method", method.name},
                    {"ratio", method.ratio},
                    {"median", percentile(relative, 0.5)},
                    {"within_1_percent", share_below(relative, 0.01)},
                    {"most", percentile(relative, 1.0)},
                    {"near_median", percentile(near, 0.5)},
                    {"near_within_1_percent", share_below(near, 0.01)},
                    {"near_most", percentile(near, 1.0)},
                    {"of_reflectance_most", percentile(absolute, 1.0)},
                    {"samples", samples / cases},
                    {"microseconds", 1e6 * seconds / cases}});
    save({{"cases", cases}, {"rows", rows}});
  }
}

void dipole_profiles(const Request& request, Progress& progress, const Save& save) {
  const auto photons = static_cast<std::uint64_t>(request.size == Size::quick ? 20'000 : 1'000'000);
  constexpr double deep = 300.0;  // mean free paths
  Json rows = Json::array();
  for (const double eta : {1.0, 1.3, 1.5}) {
    for (const double albedo : {0.5, 0.8, 0.9, 0.95, 0.99, 0.999}) {
      progress.update("bench dipole", 0.5, "photons in a half-space");
      const OpticalSlab slab{eta, 1.0, deep, 1.0 - albedo, albedo, 0.0};
      const SlabTotals traced = trace_slab(slab, Incidence::normal, photons, request.seed);
      const double t = boundary_constants(eta).normal_transmittance;
      const double exact = (traced.reflected - (1.0 - t)) / t;
      Json row{{"eta", eta},
               {"albedo", albedo},
               {"monte_carlo", exact},
               {"standard_error", traced.reflected_error / t}};
      for (const char* name : {"dipole", "better-dipole", "beam-diffusion"}) {
        const Profile profile = make_profile(name, {1.0 / 3.0, 1.0 - albedo}, eta);
        row[name] = profile.reflectance() / exact - 1.0;
      }
      rows.push_back(std::move(row));
      save({{"photons", photons}, {"rows", rows}});
    }
  }
}

void dipole_energy(const Request& /*request*/, Progress& progress, const Save& save) {
  // [T] 3.6.1, with its A from the polynomial F_dr.
  constexpr double eta = 1.5, radius = 12.0;
  constexpr int edges = 720;
  const Material marble{1.0 / (3.0 * 2.1921), 0.0021};
  const double fdr = fdr_polynomial(eta);
  const Profile of_thesis = classical_dipole(marble, (1.0 + fdr) / (1.0 - fdr));
  const Profile of_moments = make_profile("dipole", marble, eta);
  Json rows = Json::array();
  for (const double height : {0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0}) {
    progress.update("bench dipole", 1.0, "cylinders");
    std::vector<Eigen::Vector3d> top, bottom;
    for (int i = 0; i < edges; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / edges;
      top.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
      bottom.emplace_back(top.back().x(), top.back().y(), -height);
    }
    const Eigen::Vector3d middle(0.0, 0.0, 0.0);
    const auto both = [&](const Profile& profile) {
      return form_factor(profile, top, middle).value + form_factor(profile, bottom, middle).value;
    };
    rows.push_back({{"height_mm", height},
                    {"mean_free_paths", height * 2.1921},
                    {"discs_of_the_thesis", both(of_thesis)},
                    {"discs_with_exact_moments", both(of_moments)}});
  }
  save({{"rows", rows}});
}

Subject dipole_subject() {
  return {"dipole",
          "Cost and error of the dipole's hierarchy, form factors and profiles (docs/dipole.md)",
          R"(  kappamu-studies dipole -o out/

Times are medians of wall-clock and processor time over repetitions, by section
hierarchy; a machine that is busy shows in the first, not in the second.)",
          {{"hierarchy", "2 k to 500 k triangles, RGB marble at 25 mm", dipole_hierarchy},
           {"lists", "lengths of the lists that a work-item walks, or a GPU's group of them",
            dipole_lists},
           {"point-sampling", "near triangles by form factors and by evenly spread points",
            dipole_point_sampling},
           {"deform", "objects that deform, frame by frame, as the window answers", dipole_deform},
           {"form-factors", "a random sweep against adaptive quadrature", dipole_form_factors},
           {"profiles", "total reflectance against Monte Carlo in a half-space", dipole_profiles},
           {"importance", "samples of local diffusion by importance against uniform ones",
            dipole_importance},
           {"energy", "marble cylinders that send out more than enters", dipole_energy}},
          {{"repetitions", "Frames timed per mode (default 15)", Setting::Kind::number, 1, 1000}}};
}

}  // namespace kappamu::studies
