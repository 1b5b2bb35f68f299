// The verdict on top of the page. The bounds are those of the round trip where it states
// one (0.3 px, E = 1e-3); the others say in their name what they mean.
#include <algorithm>
#include <cmath>

#include "report/sections.h"

namespace kappamu::report {

namespace {

constexpr double good_rms_px = 0.3;    // what the simulated rig reaches with room to spare
constexpr double usable_rms_px = 1.0;  // beyond, surface voxels start to mix at usual scales
constexpr double good_saturated = 1e-3;
constexpr double usable_saturated = 2e-2;
constexpr double good_used = 0.9;  // back-lit: nearly the whole face should carry data
constexpr double usable_used = 0.5;
constexpr double usable_used_front_lit = 0.3;  // lit patches are left out by design
constexpr double low_chi2 = 0.1;               // below: variances overstated, or noise fitted
constexpr double good_chi2 = 1.5;              // about 1 where model and variances are right
constexpr double usable_chi2 = 4.0;
constexpr double good_error = 1e-3;
constexpr double usable_error = 1e-2;
constexpr double noise_margin = 1.5;  // E within this factor of the noise cannot be told from it

Light graded(double value, double good, double usable) {
  return value <= good ? Light::green : value <= usable ? Light::amber : Light::red;
}

Criterion judge_calibration(const RunData& run) {
  Criterion criterion{Light::grey, "Calibration", "No lens calibration in this run."};
  if (!run.calibration) return criterion;
  const double camera = run.calibration->camera.rms_px;
  const double projector = run.calibration->projector.rms_px;
  const double worst = std::max(camera, projector);
  criterion.light = graded(worst, good_rms_px, usable_rms_px);
  criterion.sentence = "Reprojection RMS camera " + number(camera) + " px, projector " +
                       number(projector) + " px, " +
                       (worst <= good_rms_px ? "within " : "above the good ") +
                       number(good_rms_px) + " px.";
  return criterion;
}

Criterion judge_exposure(const RunData& run) {
  Criterion criterion{Light::grey, "Exposure", "No HDR images in this run."};
  if (run.hdr.empty()) return criterion;
  double saturated = 0.0;
  for (const HdrSummary& hdr : run.hdr) saturated = std::max(saturated, hdr.saturated);
  criterion.light = graded(saturated, good_saturated, usable_saturated);
  criterion.sentence = saturated == 0.0 ? "No pixel is saturated in every exposure."
                                        : percent(saturated) +
                                              " of the pixels of the worst pattern are "
                                              "saturated in every exposure.";
  if (criterion.light != Light::green) criterion.sentence += " Add a shorter exposure.";
  return criterion;
}

Criterion judge_coverage(const RunData& run) {
  Criterion criterion{Light::grey, "Coverage", "No fit patterns in this run."};
  if (!run.fit_patterns) return criterion;
  const double used = appearance_error(*run.fit_patterns).used;
  const SurfaceMeasurements& measured = run.fit_patterns->measured;
  const bool front_lit = measured.lit_face == measured.seen_face;
  const double good = front_lit ? usable_used : good_used;
  const double usable = front_lit ? usable_used_front_lit : usable_used;
  criterion.light = used >= good ? Light::green : used >= usable ? Light::amber : Light::red;
  criterion.sentence = percent(used) + " of the surface values could be used" +
                       (front_lit ? " (lit patches are left out)." : ".");
  return criterion;
}

Criterion judge_fit(const RunData& run) {
  Criterion criterion{Light::grey, "Fit", "No fit in this run yet."};
  if (!run.fit || run.fit->convergence.empty()) return criterion;
  criterion.light = Light::green;
  criterion.sentence = "χ² per value";
  bool converged = true;
  bool low = false;
  for (const Convergence& channel : run.fit->convergence) {
    const double chi2 = channel.chi2_per_value;
    Light light = graded(chi2, good_chi2, usable_chi2);
    if (chi2 < low_chi2) {
      light = Light::amber;
      low = true;
    }
    if (!channel.converged) light = std::max(light, Light::amber);
    converged = converged && channel.converged;
    criterion.light = std::max(criterion.light, light);
    criterion.sentence += " " + channel.channel + " " + number(chi2) + ",";
  }
  criterion.sentence += " where 1 is data explained to their noise; ";
  criterion.sentence += converged ? "every channel converged." : "a channel did not converge.";
  if (low) criterion.sentence += " So low a value says that the variances are overstated.";
  return criterion;
}

Criterion judge_prediction(const RunData& run) {
  Criterion criterion{Light::grey, "Held-out light",
                      "No patterns were kept out of the fit: nothing independent judges it."};
  if (!run.validate_patterns || run.validate_patterns->predicted.empty()) return criterion;
  // Pattern by pattern: a sum over all would be that of the brightest.
  const Comparison& comparison = *run.validate_patterns;
  const std::size_t count = comparison.patterns.size();
  double mean = 0.0, noise = 0.0, worst = 0.0;
  std::string worst_pattern;
  for (std::size_t pattern = 0; pattern < count; ++pattern) {
    const AppearanceError error = appearance_error(comparison, std::nullopt, pattern);
    mean += error.error / static_cast<double>(count);
    noise += error.noise / static_cast<double>(count);
    if (error.error < worst) continue;
    worst = error.error;
    worst_pattern = comparison.patterns[pattern];
  }
  criterion.light =
      mean <= noise_margin * noise ? Light::green : graded(mean, good_error, usable_error);
  criterion.sentence = "Appearance error E = " + number(mean, 2) + " on average over " +
                       std::to_string(count) + " patterns the fit never saw, " + number(worst, 2) +
                       " at worst (" + worst_pattern + "); the photographs' own noise makes " +
                       number(noise, 2) + ".";
  return criterion;
}

Criterion judge_warnings(const RunData& run) {
  const std::size_t count = all_warnings(run).size();
  if (count == 0) return {Light::green, "Warnings", "None."};
  return {Light::amber, "Warnings",
          std::to_string(count) + (count == 1 ? " warning" : " warnings") + ", listed below."};
}

std::string css_name(Light light) {
  switch (light) {
    case Light::green:
      return "green";
    case Light::amber:
      return "amber";
    case Light::red:
      return "red";
    case Light::grey:
      break;
  }
  return "grey";
}

std::string headline(Light light) {
  switch (light) {
    case Light::green:
      return "This fit can be trusted.";
    case Light::amber:
      return "Usable, with reservations: look at the amber lines.";
    case Light::red:
      return "Do not trust this fit: see the red lines.";
    case Light::grey:
      break;
  }
  return "Nothing to judge yet.";
}

}  // namespace

std::vector<Criterion> judge(const RunData& run) {
  return {judge_calibration(run), judge_exposure(run),   judge_coverage(run),
          judge_fit(run),         judge_prediction(run), judge_warnings(run)};
}

Light overall(const std::vector<Criterion>& criteria) {
  // Green, amber, red are in rising order; without a fit no other criterion can vouch for one.
  Light worst = Light::grey;
  for (const Criterion& criterion : criteria) {
    if (criterion.name == "Fit" && criterion.light == Light::grey) return Light::grey;
    if (criterion.light == Light::grey) continue;
    worst = worst == Light::grey ? criterion.light : std::max(worst, criterion.light);
  }
  return worst;
}

Html verdict_section(const std::vector<Criterion>& criteria) {
  const Light light = overall(criteria);
  Html lines;
  for (const Criterion& criterion : criteria)
    lines += element(
        "tr",
        element("td", element("span", {{"class", "lamp " + css_name(criterion.light)}}, text(""))) +
            element("th", text(criterion.name)) + element("td", text(criterion.sentence)));
  return element("section", {{"class", "verdict " + css_name(light)}},
                 element("h2", text(headline(light))) +
                     element("table", {{"class", "criteria"}}, element("tbody", lines)));
}

}  // namespace kappamu::report
