// Measured against re-rendered surfaces, pattern by pattern.
#include <algorithm>
#include <array>
#include <cmath>

#include "report/drawing/picture.h"
#include "report/sections.h"

namespace kappamu::report {

namespace {

constexpr int stored_pixels = 112;  // longest side of a stored map: keeps 20 patterns below 10 MB
constexpr int shown_width = 128;    // CSS px

Image<float> irradiance_image(const SurfaceMeasurements& measured, std::size_t pattern) {
  const FaceShape shape = measured.lit_shape();
  Image<float> image(shape.nu, shape.nv, 1);
  std::copy_n(measured.irradiance.begin() + static_cast<std::ptrdiff_t>(pattern * shape.cells()),
              shape.cells(), image.values().begin());
  return image;
}

/// Maps have u to the right and v down (core/grid.h); so drawn, these faces are seen from inside.
bool drawn_from_inside(Face face) {
  return face == Face::x_plus || face == Face::y_minus || face == Face::z_plus;
}

/// A map of the seen face as someone before that face sees it.
Image<float> from_outside(Image<float> map, Face face) {
  if (!drawn_from_inside(face)) return map;
  Image<float> turned(map.width(), map.height(), map.channels());
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x)
      for (int c = 0; c < map.channels(); ++c) turned(map.width() - 1 - x, y, c) = map(x, y, c);
  return turned;
}

std::string axes_of(Face face) {
  constexpr std::array<const char*, 3> u{"y", "x", "x"};
  constexpr std::array<const char*, 3> v{"z", "z", "y"};
  const auto axis = static_cast<std::size_t>(axis_of(face));
  return std::string(u[axis]) + (drawn_from_inside(face) ? " to the left, " : " to the right, ") +
         v[axis] + " down";
}

/// (predicted − measured) of one channel, not a number where the mask leaves the value out.
Image<float> residual_image(const Comparison& comparison, std::size_t channel,
                            std::size_t pattern) {
  const SurfaceMeasurements& measured = comparison.measured;
  const FaceShape shape = measured.seen_shape();
  Image<float> image(shape.nu, shape.nv, 1);
  const std::size_t first =
      (channel * static_cast<std::size_t>(measured.patterns) + pattern) * shape.cells();
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    const bool used = measured.mask.empty() || measured.mask[first + i] != 0;
    image.values()[i] =
        used ? comparison.predicted[first + i] - measured.value[first + i] : std::nanf("");
  }
  return image;
}

double brightest(const SurfaceMeasurements& measured, std::size_t pattern) {
  const Image<float> image = pattern_image(measured, measured.value, pattern);
  return quantile(image.values(), 0.999);
}

/// One scale for every residual map of a group: the 99 % quantile of |residual| / brightest, at
/// least 1 %, rounded up to a round number.
double residual_scale(const Comparison& comparison) {
  std::vector<float> relative;
  for (std::size_t pattern = 0; pattern < comparison.patterns.size(); ++pattern) {
    const double white = std::max(brightest(comparison.measured, pattern), 1e-30);
    for (std::size_t c = 0; c < comparison.measured.channels.size(); ++c) {
      const Image<float> residual = residual_image(comparison, c, pattern);
      for (const float value : residual.values())
        relative.push_back(static_cast<float>(std::abs(value) / white));
    }
  }
  const double wanted = std::max(quantile(std::move(relative), 0.99), 0.01);
  for (const double round : {0.01, 0.02, 0.05, 0.1, 0.2, 0.5})
    if (wanted <= round) return round;
  return 1.0;
}

Html pattern_row(const Comparison& comparison, std::size_t pattern, double scale) {
  const SurfaceMeasurements& measured = comparison.measured;
  const double white = brightest(measured, pattern);
  const Face face = measured.seen_on(static_cast<int>(pattern));
  const std::string name =
      comparison.patterns[pattern] + (face == measured.seen_face ? "" : " on " + to_string(face));
  const auto shown = [&](const std::vector<float>& values, const std::string& what) {
    return picture(tone_mapped(reduced(from_outside(pattern_image(measured, values, pattern), face),
                                       stored_pixels),
                               white),
                   shown_width, what + " of " + name);
  };
  const Image<float> light =
      reduced(from_outside(irradiance_image(measured, pattern), measured.lit_face), stored_pixels);
  Html cells =
      element("th", text(name)) +
      element("td", picture(tone_mapped(light, std::max(1e-30, quantile(light.values(), 1.0))),
                            shown_width, "light of " + name)) +
      element("td", shown(measured.value, "measured"));
  if (comparison.predicted.empty()) return element("tr", cells);
  cells += element("td", shown(comparison.predicted, "re-rendered"));
  for (std::size_t c = 0; c < std::min<std::size_t>(measured.channels.size(), 3); ++c)
    cells += element(
        "td", picture(coloured(reduced(from_outside(residual_image(comparison, c, pattern), face),
                                       stored_pixels),
                               ColourMap::diverging, -scale * white, scale * white),
                      shown_width, "residual " + measured.channels[c] + " of " + name));
  const AppearanceError error = appearance_error(comparison, pattern);
  const double used = static_cast<double>(error.count) /
                      static_cast<double>(measured.channels.size() * measured.seen_shape().cells());
  cells += element("td", {{"class", "figures"}},
                   text("E of this pattern " + number(error.E())) + empty_element("br", {}) +
                       text("noise " + number(error.noise_E())) + empty_element("br", {}) +
                       text(percent(used) + " used"));
  return element("tr", cells);
}

Html group(const std::string& title, const Comparison& comparison) {
  const bool has_prediction = !comparison.predicted.empty();
  Html head;
  for (const std::string& name :
       {std::string("Pattern"), std::string("light"), std::string("measured")})
    head += element("th", text(name));
  double scale = 0.0;
  if (has_prediction) {
    scale = residual_scale(comparison);
    head += element("th", text("re-rendered"));
    for (std::size_t c = 0; c < std::min<std::size_t>(comparison.measured.channels.size(), 3); ++c)
      head += element("th", text("residual " + comparison.measured.channels[c]));
    head += element("th", text(""));
  }
  Html rows;
  for (std::size_t pattern = 0; pattern < comparison.patterns.size(); ++pattern)
    rows += pattern_row(comparison, pattern, scale);
  const SurfaceMeasurements& measured = comparison.measured;
  const std::string whence =
      "Light as seen from the projector, before face " + to_string(measured.lit_face) + ": " +
      axes_of(measured.lit_face) + ". The other pictures as seen by the camera, before face " +
      to_string(measured.seen_face) + ": " + axes_of(measured.seen_face) +
      (measured.two_faces() ? "; those named \"on " + to_string(opposite(measured.seen_face)) +
                                  "\" before that face: " + axes_of(opposite(measured.seen_face))
                            : "") +
      ".";
  Html content =
      note(whence) + element("table", {{"class", "pictures"}},
                             element("thead", element("tr", head)) + element("tbody", rows));
  if (has_prediction) {
    content = legend(ColourMap::diverging, -100.0 * scale, 100.0 * scale,
                     "residual, re-rendered − measured [% of the pattern's brightest value]") +
              content;
  } else {
    content += note("No fit has predicted these patterns yet.");
  }
  return subsection(title, content);
}

}  // namespace

Html comparison_section(const RunData& run) {
  Html content;
  if (run.validate_patterns)
    content += group("Validation patterns, which the fit did not see", *run.validate_patterns);
  else
    content += note("No patterns were kept out of the fit for validation.");
  if (run.fit_patterns) content += group("Fitted patterns", *run.fit_patterns);
  content += note(
      "Measured and re-rendered pictures share one exposure per pattern (white at the 99.9 % "
      "quantile of the measured one) and are shown with the sRGB curve. Grey in a residual map: "
      "left out of the comparison (lit, saturated or unseen). A good fit leaves noise without "
      "structure.");
  return section("Measured against re-rendered", content);
}

}  // namespace kappamu::report
