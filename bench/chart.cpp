#include "bench/chart.h"

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "core/error.h"
#include "io/atomic_file.h"

namespace kappamu::bench {

namespace {

namespace fs = std::filesystem;

// Okabe and Ito's palette (2008), told apart by colour-blind readers, and four darker ones.
constexpr std::array<const char*, 12> palette{"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                              "#E69F00", "#56B4E9", "#000000", "#8C6D00",
                                              "#7F3C8D", "#666666", "#A50026", "#2F6B3A"};

/// A double-quoted string of gnuplot's.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

bool drawable(double value, bool logarithmic) {
  return std::isfinite(value) && (!logarithmic || value > 0.0);
}

void write_data(const Chart& chart, const Series& series, const std::string& name,
                std::ostream& out) {
  if (series.x.size() != series.y.size() ||
      (!series.y_error.empty() && series.y_error.size() != series.y.size())) {
    throw InputError("chart '" + chart.title + "': series '" + series.label +
                     "' has unequal lengths of x, y and y_error.");
  }
  out << name << " << END\n";
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!drawable(series.x[i], chart.log_x) || !drawable(series.y[i], chart.log_y)) continue;
    out << series.x[i] << ' ' << series.y[i];
    if (!series.y_error.empty()) out << ' ' << series.y_error[i];
    out << '\n';
  }
  out << "END\n";
}

bool has_points(const Chart& chart, const Series& series) {
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (drawable(series.x[i], chart.log_x) && drawable(series.y[i], chart.log_y)) return true;
  }
  return false;
}

std::string look(const Series& series, int colour, int mark) {
  const std::string line =
      " lc rgb \"" + std::string(palette[static_cast<std::size_t>(colour - 1) % palette.size()]) +
      "\"";
  const std::string point = " pt " + std::to_string(4 + mark % 10) + " ps 1.1";
  switch (series.style) {
    case Series::Style::points:
      return "with points" + point + line;
    case Series::Style::line:
      return "with lines lw 2" + line;
    case Series::Style::dashes:
      return "with lines lw 1.5 dt 2" + line;
    case Series::Style::line_and_points:
      return "with linespoints lw 1.8" + point + line;
  }
  throw InternalError("chart: unknown style");
}

void write_axis(char axis, bool logarithmic, const std::string& label,
                const std::optional<std::pair<double, double>>& range, std::ostream& out) {
  out << "set " << axis << "label " << quoted(label) << "\n";
  out << (logarithmic ? "set logscale " : "unset logscale ") << axis << "\n";
  // Powers of ten where they say it best; plain numbers on linear axes.
  out << "set format " << axis << (logarithmic ? " \"10^{%T}\"\n" : " \"%g\"\n");
  if (range) {
    out << "set " << axis << "range [" << range->first << ':' << range->second << "]\n";
  } else {
    out << "set " << axis << "range [*:*]\n";
  }
}

void write_chart(const Chart& chart, int number, std::ostream& out) {
  const auto data_name = [&](std::size_t i) {
    return "$chart" + std::to_string(number) + "_" + std::to_string(i + 1);
  };
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    write_data(chart, chart.series[i], data_name(i), out);
  }
  out << "set title " << quoted(chart.title) << " font \",13\"\n";
  write_axis('x', chart.log_x, chart.x_label, chart.x_range, out);
  write_axis('y', chart.log_y, chart.y_label, chart.y_range, out);
  out << "set key " << chart.legend << "\n";
  std::string plots;
  int next_colour = 1, mark = 0;
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const Series& series = chart.series[i];
    const int colour = series.colour.value_or(next_colour);
    if (!series.colour) ++next_colour;
    if (!has_points(chart, series)) continue;
    plots += (plots.empty() ? "plot " : ", \\\n     ") + data_name(i) + " using 1:2 " +
             look(series, colour, mark) +
             (series.label.empty() ? " notitle" : " title " + quoted(series.label));
    // Lines without marks use none up: a method keeps its mark from chart to chart.
    if (series.style == Series::Style::points || series.style == Series::Style::line_and_points) {
      ++mark;
    }
    if (!series.y_error.empty()) {
      plots += ", \\\n     " + data_name(i) + " using 1:2:3 with yerrorbars pt 0 lc rgb \"" +
               palette[static_cast<std::size_t>(colour - 1) % palette.size()] + "\" notitle";
    }
  }
  if (plots.empty()) throw InputError("chart '" + chart.title + "' has no point to draw.");
  out << plots << "\n";
}

/// The program's exit status, its standard error in `log`.
int run_gnuplot(const fs::path& script, const fs::path& log) {
  const pid_t child = fork();
  if (child == 0) {
    if (std::freopen(log.c_str(), "w", stderr) == nullptr) _exit(126);
    execlp("gnuplot", "gnuplot", script.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child) return 126;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 126;
}

}  // namespace

void render(const fs::path& png, const std::function<std::string(const std::string&)>& script_for) {
  fs::path script = png;
  script.replace_extension(".gp");
  io::write_atomically(png, [&](const fs::path& temporary) {
    const fs::path work = temporary.string() + ".gp", log = temporary.string() + ".log";
    io::write_text_atomically(work, script_for(quoted(temporary.string())));
    const int status = run_gnuplot(work, log);
    std::error_code ignored;
    fs::remove(work, ignored);
    if (status == 127) {
      fs::remove(log, ignored);
      throw InputError("gnuplot is not installed; install the Debian package gnuplot-nox.");
    }
    if (status != 0) {
      throw InputError("gnuplot refused the chart " + png.string() + "; see " + log.string() + ".");
    }
    fs::remove(log, ignored);
    io::write_text_atomically(script, script_for(quoted(png.filename().string())));
  });
}

void draw(std::span<const Chart> charts, const fs::path& png, int columns, int width, int height) {
  check(!charts.empty() && columns >= 1, "draw: at least one chart and one column");
  const int count = static_cast<int>(charts.size());
  const int across = std::min(columns, count);
  const int rows = (count + across - 1) / across;
  render(png, [&](const std::string& output) {
    std::ostringstream text;
    text.precision(9);
    text << "set encoding utf8\nset terminal pngcairo size " << across * width << ','
         << rows * height << " enhanced font \"DejaVu Sans,11\"\n"
         << "set output " << output << "\n"
         << "set grid xtics ytics lc rgb \"#d8d8d8\" lt 1\n"
         << "set border lw 1.2\nset tics nomirror\n";
    if (count > 1) text << "set multiplot layout " << rows << ',' << across << "\n";
    for (int i = 0; i < count; ++i) write_chart(charts[static_cast<std::size_t>(i)], i + 1, text);
    if (count > 1) text << "unset multiplot\n";
    return text.str();
  });
}

}  // namespace kappamu::bench
