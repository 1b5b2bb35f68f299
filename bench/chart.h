// Charts of measurements, drawn by gnuplot. Beside every picture lies the script that drew it, data
// included: `gnuplot chart.gp` in its folder remakes the picture, and a reader can take the
// numbers.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace kappamu::bench {

/// Texts are gnuplot's enhanced ones: 10^{-6} is a power, x_0 an index.
struct Series {
  enum class Style { line_and_points, points, line, dashes };

  std::string label;  ///< in the legend; empty: not there
  std::vector<double> x, y;
  std::vector<double> y_error;  ///< half the length of a bar at each point; empty: no bars
  Style style = Style::line_and_points;
  std::optional<int> colour = {};  ///< 1 to 12, shared by series of equal number; unset: the next
};

struct Chart {
  std::string title;
  std::string x_label, y_label;  ///< with units
  bool log_x = false, log_y = false;
  std::optional<std::pair<double, double>> x_range, y_range;  ///< in order of the axis
  std::string legend = "outside right top";                   ///< as gnuplot's `set key`
  std::vector<Series> series;
};

/// Draws the charts in a row-wise raster of `columns` into `png`, each `width` × `height` pixels.
/// Points that are not finite, or not positive on a logarithmic axis, are left out. Throws
/// InputError when gnuplot is not installed or refuses, or when a series has unequal lengths.
void draw(std::span<const Chart> charts, const std::filesystem::path& png, int columns = 1,
          int width = 900, int height = 560);

/// The same for a script of the caller's: `script_for` gets the output file, quoted for gnuplot.
void render(const std::filesystem::path& png,
            const std::function<std::string(const std::string& output)>& script_for);

}  // namespace kappamu::bench
