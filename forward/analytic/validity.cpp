#include "forward/analytic/validity.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu::forward {

namespace {

#include "forward/analytic/validity_table.inc"

/// The cell of an axis (increasing in `of`) that holds x, and where in it; clamped to the ends.
struct Place {
  std::size_t low = 0;
  double part = 0.0;
};
template <std::size_t n, class F>
Place place(const std::array<double, n>& axis, double x, F of) {
  std::size_t low = 0;
  while (low + 2 < n && of(axis[low + 1]) < x) ++low;
  const double a = of(axis[low]), b = of(axis[low + 1]);
  return {low, std::clamp((x - a) / (b - a), 0.0, 1.0)};
}

}  // namespace

ValidityEstimate diffusion_validity(double albedo, double mean_free_paths) {
  check(mean_free_paths > 0.0 && albedo <= 1.0, "diffusion_validity: no such slab");
  const auto scattering = [](double a) { return -std::log(std::max(1e-6, 1.0 - a)); };
  const auto thickness = [](double t) { return std::log(t); };
  const Place row = place(table_albedo, scattering(albedo), scattering);
  const Place column = place(table_thickness, thickness(mean_free_paths), thickness);
  const auto interpolate = [&](std::optional<double> ValidityEstimate::*member) {
    std::optional<double> sum = 0.0;
    for (const std::size_t i : {0, 1}) {
      for (const std::size_t j : {0, 1}) {
        const double weight =
            (i == 1 ? row.part : 1.0 - row.part) * (j == 1 ? column.part : 1.0 - column.part);
        if (weight == 0.0) continue;
        const auto& corner =
            table_error[(row.low + i) * table_thickness.size() + column.low + j].*member;
        sum = sum && corner ? std::optional(*sum + weight * *corner) : std::nullopt;
      }
    }
    return sum;
  };
  return {interpolate(&ValidityEstimate::reflected), interpolate(&ValidityEstimate::transmitted),
          interpolate(&ValidityEstimate::far_map)};
}

bool in_validity_table(double albedo, double mean_free_paths) {
  return albedo >= table_albedo.front() && mean_free_paths >= table_thickness.front();
}

std::optional<std::string> validity_warning(const GridSetup& setup, const Medium& medium,
                                            double tolerable) {
  double extinction = 0.0, absorption = 0.0;
  for (std::size_t i = 0; i < medium.kappa.size(); ++i) {
    extinction += 1.0 / (3.0 * medium.kappa[i]);
    absorption += medium.mu[i];
  }
  const double albedo = std::max(0.0, 1.0 - absorption / extinction);
  const double paths = extinction / static_cast<double>(medium.kappa.size()) * setup.thickness_mm();
  const ValidityEstimate estimate = diffusion_validity(albedo, paths);
  const auto much = [&](const std::optional<double>& error) {
    return error && std::abs(*error) > tolerable;
  };
  if (!much(estimate.reflected) && !much(estimate.transmitted) && !much(estimate.far_map)) {
    return std::nullopt;
  }
  std::string text = formatted(
      "under collimated light diffusion errs in a slab of this block's mean coefficients (albedo "
      "%.2g, %.2g transport mean free paths thick) by",
      albedo, paths);
  const char* separator = " ";
  const auto add = [&](const std::optional<double>& error, const char* what) {
    if (!error) return;
    text += formatted("%s%.2g %% in %s", separator, 100.0 * *error, what);
    separator = ", ";
  };
  add(estimate.reflected, "the light reflected");
  add(estimate.transmitted, "the light transmitted");
  add(estimate.far_map, "the far face's map");
  if (!in_validity_table(albedo, paths)) {
    text +=
        formatted(", as measured at albedo %.2g and %.2g mean free paths",
                  std::max(albedo, table_albedo.front()), std::max(paths, table_thickness.front()));
  }
  return text +
         "; the method montecarlo shows the truth, a fit with the physics transport fits to it";
}

}  // namespace kappamu::forward
