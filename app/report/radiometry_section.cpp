#include <algorithm>
#include <cmath>

#include "app/report/chart.h"
#include "app/report/picture.h"
#include "app/report/sections.h"

namespace kappamu::app::report {

namespace {

Html response_block(const RunData& run) {
  LineChart chart;
  chart.x_label = "code value, fraction of the largest";
  chart.y_label = "linear signal";
  const auto& response = run.calibration->response;
  const std::vector<std::string> names =
      run.session ? run.session->channels : std::vector<std::string>{"R", "G", "B"};
  for (std::size_t c = 0; c < response.size(); ++c) {
    Series series;
    series.name = c < names.size() ? names[c] : "channel " + std::to_string(c);
    series.colour = channel_colour(series.name, c);
    const std::size_t codes = response[c].size();
    // 12- and 16-bit tables are far finer than a screen.
    const std::size_t stride = std::max<std::size_t>(1, codes / 256);
    for (std::size_t code = 0; code < codes; code += stride) {
      series.x.push_back(static_cast<double>(code) / static_cast<double>(codes - 1));
      series.y.push_back(response[c][code]);
    }
    chart.series.push_back(series);
  }
  return element(
      "figure",
      render(chart) + element("figcaption",
                              text("Inverse response: linear signal as a fraction of full scale")));
}

Html hdr_table(const std::vector<HdrSummary>& summaries) {
  std::vector<std::vector<Html>> rows;
  for (const HdrSummary& hdr : summaries) {
    const bool has_range = hdr.bright > 0.0 && hdr.noise > 0.0;
    rows.push_back({text(hdr.pattern), text(number(hdr.bright)), text(number(hdr.noise, 2)),
                    text(has_range ? number(std::log10(hdr.bright / hdr.noise), 2) : "–"),
                    text(percent(hdr.saturated)), text(percent(hdr.dark)),
                    text(percent(hdr.missing))});
  }
  return table({"Pattern", "bright [full scales/s]", "noise floor [full scales/s]", "decades",
                "saturated", "dark", "missing"},
               rows);
}

/// Maps of the pattern in which most is saturated, and of the first one.
Html noise_maps(const std::vector<HdrSummary>& summaries) {
  const auto brightest = std::max_element(
      summaries.begin(), summaries.end(),
      [](const HdrSummary& a, const HdrSummary& b) { return a.saturated < b.saturated; });
  std::vector<const HdrSummary*> shown{&summaries.front()};
  if (&*brightest != shown[0] && brightest->saturated > 0.0) shown.push_back(&*brightest);
  constexpr int width = 320;  // CSS px
  std::vector<Html> blocks;
  for (const HdrSummary* hdr : shown) {
    blocks.push_back(figure(picture(coloured(hdr->relative_noise, ColourMap::viridis, -4.0, -1.0),
                                    width, "relative noise of " + hdr->pattern) +
                                legend(ColourMap::viridis, -4.0, -1.0, "log10 of σ / value"),
                            hdr->pattern + ": noise of the merged picture, worst channel; grey: "
                                           "dark, saturated or missing"));
    blocks.push_back(figure(picture(coloured(hdr->saturation, ColourMap::viridis, 0.0, 1.0), width,
                                    "saturation of " + hdr->pattern) +
                                legend(ColourMap::viridis, 0.0, 1.0, "share of values"),
                            hdr->pattern + ": saturated in every frame"));
  }
  return row(blocks);
}

}  // namespace

Html radiometry_section(const RunData& run) {
  Html content;
  if (run.calibration && !run.calibration->response.empty())
    content += subsection("Camera response", response_block(run));
  if (run.hdr.empty()) {
    content += note("This run has no HDR images.");
  } else {
    content += subsection("Dynamic range and flags", hdr_table(run.hdr));
    content += note(
        "Bright is the 99.9 % quantile of valid pixels, noise floor the 1 % quantile of the "
        "standard deviation. Dark pixels are mostly background; saturated ones are left out of the "
        "fit.");
    content += subsection("Noise and saturation", noise_maps(run.hdr));
  }
  return section("Response and dynamic range", content);
}

}  // namespace kappamu::app::report
