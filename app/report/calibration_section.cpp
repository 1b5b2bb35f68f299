#include <algorithm>
#include <cmath>

#include "app/report/chart.h"
#include "app/report/sections.h"

namespace kappamu::app::report {

namespace {

/// Residuals enlarged so that a typical one (their RMS) is drawn as 3 % of the picture's width,
/// rounded to a power of ten times 1, 2 or 5.
double drawing_scale(const LensCalibration& lens) {
  double sum = 0.0;
  for (std::size_t i = 0; i < lens.dx.size(); ++i)
    sum += lens.dx[i] * lens.dx[i] + lens.dy[i] * lens.dy[i];
  const double rms = std::sqrt(sum / std::max<double>(1.0, static_cast<double>(lens.dx.size())));
  if (rms <= 0.0) return 1.0;
  const double wanted = 0.03 * lens.width / rms;
  const double power = std::pow(10.0, std::floor(std::log10(wanted)));
  const double digit = wanted / power;
  return power * (digit < 2.0 ? 1.0 : digit < 5.0 ? 2.0 : 5.0);
}

Html lens_block(const std::string& name, const LensCalibration& lens) {
  BarChart bars;
  bars.y_label = "RMS [px]";
  bars.values = lens.view_rms_px;
  for (std::size_t i = 0; i < lens.view_rms_px.size(); ++i)
    bars.labels.push_back(std::to_string(i));
  bars.reference = lens.rms_px;
  bars.reference_label = "all: " + number(lens.rms_px) + " px";
  std::vector<Html> blocks;
  if (!bars.values.empty())
    blocks.push_back(
        element("figure", render(bars) + element("figcaption", text("Reprojection RMS by view"))));
  if (!lens.x.empty()) {
    PointChart points;
    points.plane_width = lens.width;
    points.plane_height = lens.height;
    points.x = lens.x;
    points.y = lens.y;
    points.dx = lens.dx;
    points.dy = lens.dy;
    points.vector_scale = drawing_scale(lens);
    std::string caption = "Where the " + std::to_string(lens.x.size()) +
                          " corners lie in the picture (" + std::to_string(lens.width) + " × " +
                          std::to_string(lens.height) + " px)";
    if (!lens.dx.empty())
      caption += ", residuals drawn " + number(points.vector_scale) + " times enlarged";
    blocks.push_back(element("figure", render(points) + element("figcaption", text(caption))));
  }
  return subsection(name + ": " + number(lens.rms_px) + " px RMS", row(blocks));
}

}  // namespace

Html calibration_section(const RunData& run) {
  Html content;
  if (!run.calibration) {
    content += note("This run has no calibration: it was fitted from ready surface measurements.");
    return section("Geometric calibration", content);
  }
  content += lens_block("Camera", run.calibration->camera);
  content += lens_block("Projector", run.calibration->projector);
  content += note(
      "Views far above the others are worth a look; corners should reach into the corners of the "
      "picture, and residuals should point everywhere, without a common trend.");
  return section("Geometric calibration", content);
}

}  // namespace kappamu::app::report
