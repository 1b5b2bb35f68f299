// Charts and tables of the records of `kappamu bench forward`.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/chart.h"
#include "bench/forward_bench.h"
#include "bench/forward_record.h"
#include "bench/kernels.h"
#include "bench/record.h"
#include "bench/text.h"
#include "io/atomic_file.h"

namespace kappamu::bench {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string title_of(const Json& problem) {
  const double whole = problem.at("contrast").get<double>();
  const double background = problem.at("background_contrast").get<double>();
  const double inclusions = std::sqrt(whole / background);
  return text("%s: %s, %d patterns, contrast %g", problem.at("name").get<std::string>().c_str(),
              grid_name(shape_of(problem)).c_str(), problem.at("patterns").get<int>(),
              background > 1.0 ? background : whole) +
         (background > 1.0 ? text(" with inclusions ×%g and ÷%g", inclusions, inclusions) : "");
}

/// Time per right-hand side against true error, one line per method.
Chart time_error_chart(const std::string& title, const std::vector<Sample>& samples) {
  Chart chart;
  chart.title = title;
  chart.x_label = "true error: relative L2 distance to the converged solution, worst pattern";
  chart.y_label = "seconds per right-hand side";
  chart.log_x = chart.log_y = true;
  chart.x_range = {2.0, 1e-12};
  for (const Line& line : lines_of(samples)) {
    Series series;
    series.label = line.label;
    for (const Sample& sample : line.samples) {
      series.x.push_back(sample.error());
      series.y.push_back(sample.seconds_per_rhs);
    }
    chart.series.push_back(series);
  }
  return chart;
}

void write_table(const fs::path& folder, const std::string& name, const std::string& table) {
  io::write_text_atomically(folder / ("table-" + name + ".md"), table);
}

std::string provenance(const Json& record) {
  const Json& machine = record.at("machine");
  return text(
      "Measured on %s, %d cores, copy %.1f GB/s, load %.1f before; device %s; kappamu %s, %s, "
      "%s%s.\n",
      machine.at("cpu").get<std::string>().c_str(), machine.at("cores").get<int>(),
      machine.at("copy_bandwidth_bytes_per_second").get<double>() / 1e9,
      machine.at("load").get<double>(), record.at("device").get<std::string>().c_str(),
      record.at("program").at("kappamu").get<std::string>().c_str(),
      record.at("program").at("compiler").get<std::string>().c_str(),
      record.at("program").at("build").get<std::string>().c_str(),
      record.at("quick").get<bool>() ? "; QUICK mode, small grids" : "");
}

std::string sample_rows(const Json& record, const Json& run) {
  const Json& problem = run.at("problem");
  std::string table =
      "| method | precision | residual asked | iterations | set-up [s] | per right-hand side [s] | "
      "true error | of |\n|---|---|---|---|---|---|---|---|\n";
  for (const Sample& s : samples_from_json(run.at("samples"))) {
    table += text("| %s%s%s | %s | %.0e | %d%s | %.3f | %.4f | %.1e | %s |\n", s.method.c_str(),
                  s.setting.empty() ? "" : ": ", s.setting.c_str(), s.precision.c_str(),
                  s.tolerance, s.iterations, s.converged ? "" : " (stopped)", s.set_up_seconds,
                  s.seconds_per_rhs, s.error(), s.phi_error ? "φ" : "maps");
  }
  return "**" + title_of(problem) + "**; the converged solution is known to " +
         text("%.0e. ", problem.at("truth_error").get<double>()) + provenance(record) + "\n" +
         table;
}

std::string ratio_table(const std::vector<Sample>& samples, const std::string& other_word) {
  const Target target = target_of(samples);
  const auto ours = seconds_at_error(samples_of(samples, "multigrid", "single"), target.error);
  std::string table =
      text("Single precision attains %.1e at best, so methods meet at a true error of %.0e.\n\n",
           target.floor, target.error);
  table += "| " + other_word +
           " | seconds per right-hand side, set-up shared by all patterns | set-up paid by one | "
           "ratio to ours, shared | unshared set-up |\n|---|---|---|---|---|\n";
  for (const Line& line : lines_of(samples)) {
    const auto seconds = seconds_at_error(line.samples, target.error);
    if (!seconds || !ours) {
      table += "| " + line.label + " | not reached | | | |\n";
      continue;
    }
    const Sample& first = line.samples.front();
    const double unshared =
        *seconds + first.set_up_seconds - (first.seconds_per_rhs - first.solve_seconds_per_rhs);
    const Sample own = samples_of(samples, "multigrid", "single").front();
    const double own_unshared =
        *ours + own.set_up_seconds - (own.seconds_per_rhs - own.solve_seconds_per_rhs);
    table += text("| %s | %.4f | %.4f | %.1f | %.1f |\n", line.label.c_str(), *seconds, unshared,
                  *seconds / *ours, unshared / own_unshared);
  }
  return table;
}

void draw_time_error(const fs::path& folder, const std::string& section) {
  const auto record = record_of(folder, section);
  if (!record) return;
  std::vector<Chart> charts;
  std::string table;
  for (const Json& run : record->at("runs")) {
    charts.push_back(
        time_error_chart(title_of(run.at("problem")), samples_from_json(run.at("samples"))));
    table += sample_rows(*record, run) + "\n";
  }
  draw(charts, folder / ("bench-" + section + ".png"), charts.size() > 1 ? 2 : 1, 1000, 600);
  write_table(folder, section, table);
}

void draw_peers(const fs::path& folder) {
  const auto record = record_of(folder, "peers");
  if (!record) return;
  draw_time_error(folder, "peers");
  const Json& run = record->at("runs").at(0);
  std::string table = sample_rows(*record, run) + "\n" +
                      ratio_table(samples_from_json(run.at("samples")), "solver") + "\n";
  for (const auto& [peer, details] : run.at("peers").items()) {
    table += "- " + peer +
             text(", %d ranks, settings tried on one pattern at residual 1e-6: ",
                  details.at("ranks").get<int>());
    std::string list;
    for (const Json& trial : details.at("tried")) {
      list += (list.empty() ? "" : "; ") + trial.get<std::string>();
    }
    table += list + ".\n";
  }
  write_table(folder, "peers", table);
}

/// Ours at error 1e-2 against relaxation: a ratio where that got there, a bound where it did not.
void draw_relaxation(const fs::path& folder) {
  const auto record = record_of(folder, "relaxation");
  if (!record) return;
  draw_time_error(folder, "relaxation");
  const Json& run = record->at("runs").at(0);
  const auto samples = samples_from_json(run.at("samples"));
  std::string table = sample_rows(*record, run) + "\n";
  for (const char* method : {"relaxation", "gauss-seidel"}) {
    const auto against = relaxation_ratio(samples, method);
    if (!against) continue;
    table += text("- %s: %s%.0f times our time at a true error of 1e-2 (%.4f s)", method,
                  against->reached ? "" : "more than ", against->ratio, against->ours_seconds);
    table += against->reached
                 ? std::string(".\n")
                 : text("; after %.1f s per right-hand side its error is still %.2f.\n",
                        against->last_seconds, against->last_error);
  }
  write_table(folder, "relaxation", table);
}

/// No picture: a handful of figures.
void write_kernels(const fs::path& folder) {
  const auto record = record_of(folder, "kernels");
  if (!record) return;
  std::string table;
  for (const Json& run : record->at("runs")) {
    table += "**" + title_of(run.at("problem")) + "**, " + provenance(*record) + "\n" +
             kernel_table(run.at("profiles"));
  }
  write_table(folder, "kernels", table);
}

void draw_scaling(const fs::path& folder) {
  const auto record = record_of(folder, "scaling");
  if (!record) return;
  Chart time, iterations;
  time.title = "Cost against unknowns, cubes with inclusions, residual 1e-6, 16 patterns";
  time.x_label = iterations.x_label = "unknowns per right-hand side";
  time.y_label = "seconds per right-hand side";
  iterations.title = "Iterations against unknowns";
  iterations.y_label = "iterations of the slowest pattern";
  time.log_x = time.log_y = iterations.log_x = true;
  time.legend = iterations.legend = "left top";
  std::string table =
      "| grid | method | iterations | per right-hand side [s] | per unknown [ns] | true error |\n"
      "|---|---|---|---|---|---|\n";
  for (const char* method : {"multigrid", "hypre-pfmg"}) {
    Series seconds, counts;
    for (const Json& run : record->at("runs")) {
      const GridShape shape = shape_of(run.at("problem"));
      for (const Sample& s : samples_of(samples_from_json(run.at("samples")), method)) {
        const auto cells = static_cast<double>(shape.cells());
        seconds.label = counts.label = lines_of({s}).front().label;
        seconds.x.push_back(cells);
        seconds.y.push_back(s.seconds_per_rhs);
        counts.x.push_back(cells);
        counts.y.push_back(s.iterations);
        table += text("| %s | %s | %d | %.5f | %.1f | %.1e |\n", grid_name(shape).c_str(),
                      seconds.label.c_str(), s.iterations, s.seconds_per_rhs,
                      1e9 * s.seconds_per_rhs / cells, s.error());
      }
    }
    if (seconds.x.empty()) continue;
    if (std::string(method) == "multigrid") {
      Series linear{"proportional to unknowns", seconds.x, {}, {}, Series::Style::dashes, 10};
      for (const double x : seconds.x) linear.y.push_back(seconds.y.back() * x / seconds.x.back());
      time.series.push_back(linear);
    }
    time.series.push_back(seconds);
    iterations.series.push_back(counts);
  }
  double most = 10.0;
  for (const Series& series : iterations.series) {
    for (const double y : series.y) most = std::max(most, 1.25 * y);
  }
  iterations.y_range = {0.0, most};
  const std::vector<Chart> charts{time, iterations};
  draw(charts, folder / "bench-scaling.png", 2, 760, 560);
  write_table(folder, "scaling", provenance(*record) + "\n" + table);
}

void draw_iterations(const fs::path& folder) {
  const auto record = record_of(folder, "iterations");
  if (!record) return;
  const Json& rows = record->at("runs");
  std::vector<std::string> media, grids;
  std::vector<double> contrasts;
  const auto note = [](auto& list, const auto& value) {
    if (std::find(list.begin(), list.end(), value) == list.end()) list.push_back(value);
  };
  for (const Json& row : rows) {
    note(media, row.at("medium").get<std::string>());
    note(grids, grid_name(shape_of(row)));
    note(contrasts, row.at("contrast").get<double>());
  }
  std::vector<Chart> charts;
  std::string table = "| κ | grid |";
  for (const double contrast : contrasts) table += text(" contrast %g |", contrast);
  table += "\n|---|---|";
  for (std::size_t i = 0; i < contrasts.size(); ++i) table += "---|";
  table += "\n";
  for (const std::string& medium : media) {
    Chart chart;
    chart.title = medium + ", residual 1e-6, single precision";
    chart.x_label = "contrast of κ";
    chart.y_label = "iterations of the slowest pattern";
    chart.log_x = true;
    chart.legend = "left top";
    double most = 30.0;
    for (const std::string& grid : grids) {
      Series series;
      series.label = grid;
      table += "| " + medium + " | " + grid + " |";
      for (const Json& row : rows) {
        if (row.at("medium") != medium || grid_name(shape_of(row)) != grid) continue;
        series.x.push_back(row.at("contrast").get<double>());
        series.y.push_back(row.at("iterations").get<double>());
        most = std::max(most, series.y.back());
        table += text(" %d%s |", row.at("iterations").get<int>(),
                      row.at("converged").get<bool>() ? "" : " (stopped)");
      }
      table += "\n";
      chart.series.push_back(series);
    }
    chart.y_range = {0.0, 1.35 * most};
    charts.push_back(chart);
  }
  draw(charts, folder / "bench-iterations.png", 2, 640, 440);
  write_table(folder, "iterations", provenance(*record) + "\n" + table);
}

}  // namespace

void draw_forward(const fs::path& folder) {
  draw_time_error(folder, "headline");
  write_kernels(folder);
  draw_peers(folder);
  draw_relaxation(folder);
  draw_time_error(folder, "grids");
  draw_scaling(folder);
  draw_iterations(folder);
}

}  // namespace kappamu::bench
