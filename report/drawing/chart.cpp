#include "report/drawing/chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace kappamu::report {

namespace {

constexpr const char* axis_colour = "#9aa3ad";
constexpr const char* grid_colour = "#e6e9ec";
constexpr const char* ink = "#4a5560";

std::string pixels(double value) {
  return number(std::round(value * 10.0) / 10.0, 5);
}

Html line(double x0, double y0, double x1, double y1, const std::string& colour,
          const std::string& dash = "") {
  Attributes attributes{{"x1", pixels(x0)},
                        {"y1", pixels(y0)},
                        {"x2", pixels(x1)},
                        {"y2", pixels(y1)},
                        {"stroke", colour}};
  if (!dash.empty()) attributes.emplace_back("stroke-dasharray", dash);
  return empty_element("line", attributes);
}

Html label(double x, double y, const std::string& content, const std::string& anchor,
           const std::string& colour = ink, const std::string& transform = "") {
  Attributes attributes{
      {"x", pixels(x)}, {"y", pixels(y)}, {"text-anchor", anchor}, {"fill", colour}};
  if (colour != ink) {  // on top of data: a halo keeps it legible
    attributes.emplace_back("paint-order", "stroke");
    attributes.emplace_back("stroke", "#fff");
    attributes.emplace_back("stroke-width", "4");
  }
  if (!transform.empty()) attributes.emplace_back("transform", transform);
  return element("text", attributes, text(content));
}

Html svg(int width, int height, const Html& content) {
  return element("svg",
                 {{"width", std::to_string(width)},
                  {"height", std::to_string(height)},
                  {"viewBox", "0 0 " + std::to_string(width) + " " + std::to_string(height)},
                  {"role", "img"}},
                 content);
}

/// One axis: the range of the data, where it lies in the drawing, and its tick marks.
class Axis {
 public:
  Axis(double low, double high, bool logarithmic, double from_px, double to_px)
      : logarithmic_(logarithmic), from_px_(from_px), to_px_(to_px) {
    low_ = logarithmic ? std::log10(low) : low;
    high_ = logarithmic ? std::log10(high) : high;
    if (high_ - low_ < 1e-12 * std::max(1.0, std::abs(high_))) {
      const double margin = logarithmic ? 0.5 : std::max(0.5 * std::abs(high_), 0.5);
      low_ -= margin;
      high_ += margin;
    }
  }

  double at(double value) const {
    const double position = ((logarithmic_ ? std::log10(value) : value) - low_) / (high_ - low_);
    return from_px_ + position * (to_px_ - from_px_);
  }

  std::vector<double> ticks() const { return logarithmic_ ? decades() : steps(); }

  std::string tick_label(double value) const {
    const double exponent = std::round(std::log10(std::max(std::abs(value), 1e-300)));
    const bool is_power = logarithmic_ && std::abs(value / std::pow(10.0, exponent) - 1.0) < 1e-9;
    if (is_power && std::abs(exponent) >= 4.0)
      return "1e" + std::to_string(static_cast<int>(exponent));
    return number(value, 4);
  }

 private:
  std::vector<double> steps() const {
    const double rough = (high_ - low_) / 5.0;
    const double power = std::pow(10.0, std::floor(std::log10(rough)));
    double step = power;
    for (const double factor : {2.0, 5.0, 10.0})
      if (step < rough) step = factor * power;
    std::vector<double> result;
    for (double value = std::ceil(low_ / step - 1e-9) * step; value <= high_ + 1e-9 * step;
         value += step)
      result.push_back(std::abs(value) < 1e-9 * step ? 0.0 : value);
    return result;
  }

  std::vector<double> decades() const {
    const double span = high_ - low_;
    const int stride = std::max(1, static_cast<int>(std::ceil(span / 6.0)));
    std::vector<double> result;
    for (int k = static_cast<int>(std::ceil(low_ - 1e-9)); k <= high_ + 1e-9; k += stride) {
      result.push_back(std::pow(10.0, k));
    }
    // Less than two decades: the decades alone would say too little.
    if (result.size() < 3) {
      std::vector<double> finer;
      for (int k = static_cast<int>(std::floor(low_)); k <= high_; ++k)
        for (const double digit : {1.0, 2.0, 5.0}) {
          const double exponent = k + std::log10(digit);
          if (exponent >= low_ - 1e-9 && exponent <= high_ + 1e-9)
            finer.push_back(std::pow(10.0, exponent));
        }
      if (finer.size() > result.size()) return finer;
    }
    return result;
  }

  bool logarithmic_;
  double from_px_, to_px_;
  double low_ = 0.0, high_ = 1.0;
};

struct Frame {
  double left = 64, right = 0, top = 12, bottom = 0;
};

/// `below`: what the ticks and labels of the x axis take.
Frame frame_of(int width, int height, double below) {
  return {64.0, width - 14.0, 14.0, height - below};
}

Html y_axis(const Axis& axis, const Frame& frame, const std::string& title) {
  Html result;
  for (const double tick : axis.ticks()) {
    result += line(frame.left, axis.at(tick), frame.right, axis.at(tick), grid_colour);
    result += label(frame.left - 7, axis.at(tick) + 4, axis.tick_label(tick), "end");
  }
  const double middle = 0.5 * (frame.top + frame.bottom);
  result += label(14, middle, title, "middle", ink, "rotate(-90 14 " + pixels(middle) + ")");
  return result;
}

Html x_axis(const Axis& axis, const Frame& frame, const std::string& title) {
  Html result;
  for (const double tick : axis.ticks()) {
    result += line(axis.at(tick), frame.bottom, axis.at(tick), frame.bottom + 4, axis_colour);
    result += label(axis.at(tick), frame.bottom + 17, axis.tick_label(tick), "middle");
  }
  result += line(frame.left, frame.bottom, frame.right, frame.bottom, axis_colour);
  result += label(0.5 * (frame.left + frame.right), frame.bottom + 35, title, "middle");
  return result;
}

Html reference_line(const Axis& axis, const Frame& frame, double value, const std::string& title) {
  return line(frame.left, axis.at(value), frame.right, axis.at(value), "#b3541e", "5 4") +
         label(frame.right - 2, axis.at(value) - 5, title, "end", "#b3541e");
}

bool is_drawable(double value, bool logarithmic) {
  return std::isfinite(value) && (!logarithmic || value > 0.0);
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool empty() const { return low > high; }
};

}  // namespace

std::string channel_colour(const std::string& channel, std::size_t position) {
  if (channel == "R") return "#c0392b";
  if (channel == "G") return "#2e8b57";
  if (channel == "B") return "#2f6fb2";
  static const std::array<const char*, 6> others{"#7a4fa3", "#b8860b", "#17808a",
                                                 "#a04668", "#5b6770", "#7d8c1f"};
  return others[position % others.size()];
}

Html render(const LineChart& chart) {
  Range x_range, y_range;
  const auto drawable = [&](const Series& series, std::size_t i) {
    return is_drawable(series.x[i], chart.log_x) && is_drawable(series.y[i], chart.log_y);
  };
  for (const Series& series : chart.series)
    for (std::size_t i = 0; i < series.x.size(); ++i)
      if (drawable(series, i)) {
        x_range.include(series.x[i]);
        y_range.include(series.y[i]);
      }
  if (x_range.empty()) return {};
  if (chart.reference && is_drawable(*chart.reference, chart.log_y))
    y_range.include(*chart.reference);

  Frame frame = frame_of(chart.width, chart.height, 42.0);
  const bool has_legend = std::any_of(chart.series.begin(), chart.series.end(),
                                      [](const Series& series) { return !series.name.empty(); });
  constexpr double letter = 7.0;  // CSS px, about
  std::size_t longest = 0;
  for (const Series& series : chart.series) longest = std::max(longest, series.name.size());
  const double legend_x = frame.right - 33 - letter * static_cast<double>(longest);
  if (has_legend) frame.right = legend_x - 16;
  const Axis x(x_range.low, x_range.high, chart.log_x, frame.left, frame.right);
  const Axis y(y_range.low, y_range.high, chart.log_y, frame.bottom, frame.top);
  Html content = y_axis(y, frame, chart.y_label) + x_axis(x, frame, chart.x_label);
  if (chart.reference && is_drawable(*chart.reference, chart.log_y))
    content += reference_line(y, frame, *chart.reference, chart.reference_label);

  double legend_y = frame.top + 8;
  for (const Series& series : chart.series) {
    std::string points;
    for (std::size_t i = 0; i < series.x.size(); ++i)
      if (drawable(series, i))
        points += pixels(x.at(series.x[i])) + "," + pixels(y.at(series.y[i])) + " ";
    Attributes attributes{{"points", points},
                          {"fill", "none"},
                          {"stroke", series.colour},
                          {"stroke-width", "1.8"},
                          {"stroke-linejoin", "round"}};
    if (series.dashed) attributes.emplace_back("stroke-dasharray", "5 4");
    content += empty_element("polyline", attributes);
    if (series.name.empty()) continue;
    content += line(legend_x, legend_y - 4, legend_x + 18, legend_y - 4, series.colour,
                    series.dashed ? "5 4" : "");
    content += label(legend_x + 24, legend_y, series.name, "start");
    legend_y += 16;
  }
  return svg(chart.width, chart.height, content);
}

Html render(const BarChart& chart) {
  Range range;
  range.include(0.0);
  for (const double value : chart.values) range.include(value);
  if (chart.reference) range.include(*chart.reference);
  if (chart.values.empty()) return {};

  const Frame frame = frame_of(chart.width, chart.height, 26.0);
  const Axis y(0.0, range.high > 0.0 ? 1.08 * range.high : 1.0, false, frame.bottom, frame.top);
  Html content = y_axis(y, frame, chart.y_label);
  const double pitch = (frame.right - frame.left) / static_cast<double>(chart.values.size());
  // Labels about 26 px apart, however many bars there are.
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::ceil(26.0 / pitch)));
  for (std::size_t i = 0; i < chart.values.size(); ++i) {
    const double left = frame.left + (static_cast<double>(i) + 0.12) * pitch;
    content += empty_element("rect", {{"x", pixels(left)},
                                      {"y", pixels(y.at(chart.values[i]))},
                                      {"width", pixels(0.76 * pitch)},
                                      {"height", pixels(frame.bottom - y.at(chart.values[i]))},
                                      {"fill", chart.colour}});
    if (i % stride == 0)
      content += label(left + 0.38 * pitch, frame.bottom + 16, chart.labels[i], "middle");
  }
  content += line(frame.left, frame.bottom, frame.right, frame.bottom, axis_colour);
  if (chart.reference) content += reference_line(y, frame, *chart.reference, chart.reference_label);
  return svg(chart.width, chart.height, content);
}

Html render(const PointChart& chart) {
  if (chart.x.empty() || chart.plane_width <= 0.0 || chart.plane_height <= 0.0) return {};
  const double scale = chart.width / chart.plane_width;
  const int height = static_cast<int>(std::lround(chart.plane_height * scale));
  Html content = empty_element("rect", {{"x", "0.5"},
                                        {"y", "0.5"},
                                        {"width", pixels(chart.width - 1.0)},
                                        {"height", pixels(height - 1.0)},
                                        {"fill", "#f7f9fa"},
                                        {"stroke", axis_colour}});
  for (std::size_t i = 0; i < chart.x.size(); ++i) {
    const double x = chart.x[i] * scale;
    const double y = chart.y[i] * scale;
    if (!chart.dx.empty())
      content += line(x, y, x + chart.dx[i] * chart.vector_scale * scale,
                      y + chart.dy[i] * chart.vector_scale * scale, "#c0392b");
    content += empty_element("circle", {{"cx", pixels(x)},
                                        {"cy", pixels(y)},
                                        {"r", chart.dx.empty() ? "1.8" : "1.1"},
                                        {"fill", "#2f6fb2"}});
  }
  return svg(chart.width, height, content);
}

}  // namespace kappamu::report
