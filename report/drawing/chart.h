// Charts as inline SVG: lines, bars, and points on an image plane. Nothing is scripted or loaded.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "report/drawing/html.h"

namespace kappamu::report {

/// Colours of the channels "R", "G", "B"; others get a fixed sequence by position.
std::string channel_colour(const std::string& channel, std::size_t position);

struct Series {
  std::string name;  ///< shown in the legend; empty = no entry
  std::string colour;
  std::vector<double> x;
  std::vector<double> y;
  bool dashed = false;
};

struct LineChart {
  std::string x_label;
  std::string y_label;
  bool log_x = false;
  bool log_y = false;
  std::vector<Series> series;
  std::optional<double> reference;  ///< a horizontal dashed line
  std::string reference_label;
  int width = 520;   ///< [CSS px]
  int height = 300;  ///< [CSS px]
};
/// Points that are not finite, or not positive on a logarithmic axis, are left out. Empty where no
/// point is left.
Html render(const LineChart& chart);

struct BarChart {
  std::string y_label;
  std::vector<std::string> labels;
  std::vector<double> values;       ///< same length as labels, each finite and >= 0
  std::optional<double> reference;  ///< a horizontal dashed line
  std::string reference_label;
  std::string colour = "#4472a8";
  int width = 520;   ///< [CSS px]
  int height = 240;  ///< [CSS px]
};
Html render(const BarChart& chart);

/// Points on a picture's plane, each with a vector drawn `vector_scale` times enlarged.
struct PointChart {
  double plane_width = 0.0;    ///< [px of the picture]
  double plane_height = 0.0;   ///< [px of the picture]
  std::vector<double> x, y;    ///< [px of the picture]
  std::vector<double> dx, dy;  ///< [px of the picture]; empty = points only
  double vector_scale = 1.0;
  int width = 420;  ///< [CSS px]; the height follows the plane's aspect
};
Html render(const PointChart& chart);

}  // namespace kappamu::report
