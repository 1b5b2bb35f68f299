#include <algorithm>
#include <cmath>

#include "calib/light/stray_light.h"
#include "report/drawing/chart.h"
#include "report/drawing/picture.h"
#include "report/sections.h"

namespace kappamu::report {

namespace {

std::vector<std::string> channel_names(const RunData& run) {
  return run.session ? run.session->channels : std::vector<std::string>{"R", "G", "B"};
}

Html response_block(const RunData& run) {
  LineChart chart;
  chart.x_label = "code value, fraction of the largest";
  chart.y_label = "linear signal";
  const auto& response = run.calibration->radiometry.response.linear;
  const std::vector<std::string> names = channel_names(run);
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

Html scale_table(const RunData& run) {
  const calib::CalibrationResult& calibration = *run.calibration;
  const std::vector<std::string> names = channel_names(run);
  const double reference = calibration.scale[calibration.scale.size() / 2];
  std::vector<std::vector<Html>> rows;
  for (std::size_t c = 0; c < calibration.scale.size(); ++c) {
    const double scale = calibration.scale[c];
    rows.push_back(
        {text(c < names.size() ? names[c] : "channel " + std::to_string(c)), text(number(scale)),
         text(number(scale / reference)),
         text(c < calibration.white.residual_rms.size() ? percent(calibration.white.residual_rms[c])
                                                        : "–"),
         text(calibration.chart && c < calibration.chart->scale.size()
                  ? percent(calibration.chart->scale[c] / scale - 1.0)
                  : "–")});
  }
  return table({"Channel", "scale [full scales/s for unit radiance]", "white balance",
                "white target, residual RMS", "colour chart against it"},
               rows);
}

/// How the projector's light grows with a pixel's value.
Html projector_block(const RunData& run) {
  const calib::ProjectorCurve& curve = *run.calibration->projector_curve;
  LineChart chart;
  chart.x_label = "pixel value";
  chart.y_label = "light, share of white";
  const std::vector<std::string> names = channel_names(run);
  for (std::size_t c = 0; c < curve.light.size(); ++c) {
    Series series;
    series.name = c < names.size() ? names[c] : "channel " + std::to_string(c);
    series.colour = channel_colour(series.name, c);
    series.x.assign(curve.values.begin(), curve.values.end());
    series.y = curve.light[c];
    chart.series.push_back(series);
  }
  chart.series.push_back({.name = "proportional",
                          .colour = "#888888",
                          .x = {0.0, 255.0},
                          .y = {0.0, 1.0},
                          .dashed = true});
  return element(
      "figure",
      render(chart) + element("figcaption",
                              text("The projector's light on the white target under " +
                                   std::to_string(curve.values.size()) +
                                   " pixel values, black taken off. The channels' mean, which "
                                   "gives the patterns' light, is at most " +
                                   percent(curve.channel_spread()) + " of white away from each.")));
}

/// What black pixels, the projector's rim and stray light add or take, where they were measured.
std::string light_sentence(const calib::CalibrationResult& calibration) {
  std::string sentence;
  const calib::WhiteReference& white = calibration.white;
  if (white.black_measured && white.projector_black > 0.0) {
    sentence += "The projector's black" +
                std::string(white.room_light ? "" : ", room light included,") +
                " is 1 : " + number(1.0 / white.projector_black) + " of its white. ";
  }
  if (white.room_light) {
    sentence += "The room's light on the target, " + percent(*white.room_light) +
                " of the projector's white, was photographed with the projector off and taken "
                "off. ";
  }
  if (!white.scale.empty()) {
    double least = 1.0;
    for (const double x : {-1.0, 1.0}) {
      for (const double y : {-1.0, 1.0}) least = std::min(least, white.flat(x, y));
    }
    sentence += "At the corners of the lit face its white falls to " + percent(least) +
                " of that at the centre. ";
  }
  return sentence;
}

/// Published and measured reflectances of the neutral patches, and the stray light they tell.
Html chart_block(const RunData& run) {
  const calib::ChartReference& chart = *run.calibration->chart;
  const std::vector<std::string> names = channel_names(run);
  std::vector<std::vector<Html>> rows;
  for (const calib::NeutralPatch& neutral : chart.neutrals) {
    if (neutral.measured.size() != names.size()) continue;
    rows.push_back({text(std::to_string(neutral.patch + 1)), text(number(neutral.published))});
    for (std::size_t c = 0; c < names.size(); ++c) {
      rows.back().push_back(text(number(neutral.measured[c]) + " (" +
                                 percent(neutral.measured[c] / neutral.published - 1.0) + ")"));
    }
  }
  std::vector<std::string> heads{"Neutral patch", "published"};
  heads.insert(heads.end(), names.begin(), names.end());
  std::string stray;
  for (std::size_t c = 0; c < names.size(); ++c) {
    if (const auto share = calib::stray_light(chart, c)) {
      stray += (stray.empty() ? "" : ", ") + names[c] + " " + percent(*share);
    }
  }
  return table(heads, rows) +
         note("Residual of the patches above 5 %: " + percent(chart.residual_rms) +
              ". Stray light (room light and flare) that the dark patches show, of white: " +
              (stray.empty() ? "not determined" : stray) + ".");
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
/// Decades of each pixel's brightest channel above the picture's noise floor.
Image<float> dynamic_range(const HdrSummary& hdr) {
  const Image<float>& radiance = hdr.thumbnail;
  Image<float> decades(radiance.width(), radiance.height(), 1);
  for (int y = 0; y < decades.height(); ++y) {
    for (int x = 0; x < decades.width(); ++x) {
      float brightest = radiance(x, y, 0);
      for (int c = 1; c < radiance.channels(); ++c) {
        brightest = std::max(brightest, radiance(x, y, c));
      }
      decades(x, y) = static_cast<float>(std::log10(brightest / hdr.noise));
    }
  }
  return decades;
}

Html dynamic_range_map(const HdrSummary& hdr, int width) {
  const double high = std::ceil(std::log10(hdr.bright / hdr.noise));
  return figure(picture(coloured(dynamic_range(hdr), ColourMap::viridis, 0.0, high), width,
                        "dynamic range of " + hdr.pattern) +
                    legend(ColourMap::viridis, 0.0, high, "decades above the noise floor"),
                hdr.pattern + ": dynamic range, brightest channel; grey: below zero");
}

Html hdr_maps(const std::vector<HdrSummary>& summaries) {
  const auto brightest = std::max_element(
      summaries.begin(), summaries.end(),
      [](const HdrSummary& a, const HdrSummary& b) { return a.saturated < b.saturated; });
  std::vector<const HdrSummary*> shown{&summaries.front()};
  if (&*brightest != shown[0] && brightest->saturated > 0.0) shown.push_back(&*brightest);
  constexpr int width = 320;  // CSS px
  std::vector<Html> blocks;
  for (const HdrSummary* hdr : shown) {
    if (hdr->noise > 0.0) blocks.push_back(dynamic_range_map(*hdr, width));
    blocks.push_back(figure(picture(coloured(hdr->relative_noise, ColourMap::viridis, -4.0, -1.0),
                                    width, "relative noise of " + hdr->pattern) +
                                legend(ColourMap::viridis, -4.0, -1.0, "log10 of σ / value"),
                            hdr->pattern + ": noise, worst channel; grey: not merged"));
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
  if (run.calibration && !run.calibration->radiometry.response.linear.empty())
    content += subsection("Camera response", response_block(run));
  if (run.calibration && !run.calibration->scale.empty()) {
    content += subsection("Scale and white balance", scale_table(run));
    const std::string sentence = light_sentence(*run.calibration);
    if (!sentence.empty()) content += note(sentence);
    if (run.calibration->projector_curve) {
      content += subsection("Projector response", projector_block(run));
    }
    if (run.calibration->chart)
      content += subsection("Neutral patches of the colour chart", chart_block(run));
  }
  if (run.hdr.empty()) {
    content += note("This run has no HDR images.");
  } else {
    content += subsection("Exposure of each pattern", hdr_table(run.hdr));
    content += note(
        "Bright is the 99.9 % quantile of valid pixels, noise floor the 1 % quantile of the "
        "standard deviation. Dark pixels are mostly background; saturated ones are left out of the "
        "fit.");
    content += subsection("Dynamic range, noise and saturation", hdr_maps(run.hdr));
  }
  return section("Response and dynamic range", content);
}

}  // namespace kappamu::report
