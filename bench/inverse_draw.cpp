// Charts and tables of `kappamu bench inverse`, from its records.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bench/chart.h"
#include "bench/forward_record.h"
#include "bench/inverse_bench.h"
#include "bench/inverse_fit.h"
#include "bench/inverse_photons.h"
#include "bench/inverse_samples.h"
#include "bench/record.h"
#include "io/atomic_file.h"

namespace kappamu::bench {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Fits = std::vector<FitScore>;

std::string text(const char* format, double value) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}
std::string scientific(double value) {
  return text("%.1e", value);
}

Series line(const std::string& label) {
  Series series;
  series.label = label;
  return series;
}

Fits fits_of(const Json& record) {
  Fits fits;
  for (const Json& object : record.at("fits")) fits.push_back(fit_score_from_json(object));
  return fits;
}

std::string label_of(const std::string& name) {
  for (const Way& way : inverse_ways()) {
    if (way.name == name) return way.label;
  }
  return name;
}

std::vector<double> noises_of(const Fits& fits) {
  std::vector<double> noises;
  for (const FitScore& f : fits) {
    if (std::find(noises.begin(), noises.end(), f.noise) == noises.end()) noises.push_back(f.noise);
  }
  return noises;
}

Chart course_chart(const Fits& fits, double noise, bool against_time) {
  Chart chart;
  chart.title = "noise " + text("%g %%", 100.0 * noise);
  chart.x_label =
      against_time ? "seconds" : "work: iterations of the fitted grid, 16 patterns each";
  chart.legend = "inside right top";
  chart.y_label = "E under held-out 8 x 8 patches";
  chart.log_x = chart.log_y = true;
  for (const FitScore& f : fits) {
    if (f.noise != noise) continue;
    Series series;
    series.label = label_of(f.way);
    for (const CoursePoint& p : f.course) {
      series.x.push_back(against_time ? p.seconds : p.work);
      series.y.push_back(p.error);
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

/// The best E of `other`, its solves and work there over those of the default, and its solves at
/// its end over those of the default at that E: a fixed weight may end above its best.
std::string ratio_of(const FitScore& ours, const FitScore& other) {
  double best = HUGE_VAL;
  for (const CoursePoint& p : other.course) best = std::min(best, p.error);
  const CoursePoint* theirs = first_to_reach(other.course, best);
  const CoursePoint* mine = first_to_reach(ours.course, best);
  const CoursePoint* mine_at_end = first_to_reach(ours.course, other.patches_error);
  const auto times = [](double a, double b) { return text("%.1f", a / b); };
  return scientific(best) + " | " +
         (mine == nullptr
              ? "never there | "
              : times(theirs->solves, mine->solves) + " | " + times(theirs->work, mine->work)) +
         " | " + (mine_at_end == nullptr ? "" : times(other.solves, mine_at_end->solves));
}

std::string draw_optimisers(const Fits& fits, const fs::path& png) {
  std::vector<Chart> charts;
  std::ostringstream table;
  table << "| noise | way to fit | E, 8 × 8 patches | E, single voxels | χ² | solves | work | "
           "seconds | "
           "its best E | solves there over ours there | work there over ours there | solves at its "
           "end over ours at that E |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const double noise : noises_of(fits)) {
    charts.push_back(course_chart(fits, noise, true));
    charts.push_back(course_chart(fits, noise, false));
    const FitScore* ours = nullptr;
    for (const FitScore& f : fits) {
      if (f.noise != noise) continue;
      if (f.way == "default") ours = &f;
      table << "| " << text("%g %%", 100.0 * noise) << " | " << label_of(f.way) << " | "
            << scientific(f.patches_error) << " | " << scientific(f.single_error) << " | "
            << text("%.2f", f.chi2) << " | " << f.solves << " | " << text("%.0f", f.work) << " | "
            << text("%.1f", f.seconds) << " | "
            << (ours != nullptr && &f != ours ? ratio_of(*ours, f) : " | | | ") << " |\n";
    }
  }
  draw(charts, png, 2);
  return table.str();
}

/// What a reader must know of the machine and of the size, above each table.
std::string provenance(const Json& record) {
  const Json& machine = record.at("machine");
  const std::string size = record.at("size").get<std::string>();
  return "Measured on " + machine.at("cpu").get<std::string>() + ", " +
         std::to_string(machine.at("cores").get<int>()) + " cores, load " +
         text("%.1f", machine.at("load").get<double>()) + " before; device " +
         record.at("fits").at(0).at("device").get<std::string>() +
         (size == "full" ? "" : "; the " + size + " form of the command") + ".\n\n";
}

double worst(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

std::string draw_scores(const Fits& fits, const fs::path& png) {
  std::ostringstream table;
  table << "| light | noise | truths | E, 8 × 8 patches: median, worst | "
           "E, single voxels: median, worst | χ², worst | solves, median | work, median |\n"
           "|---|---|---|---|---|---|---|---|\n";
  std::vector<Chart> charts(2);
  for (std::size_t c = 0; c < 2; ++c) {
    charts[c].title = c == 0 ? "error of κ by depth" : "error of μ by depth";
    charts[c].x_label = "layer, 1 = lit face";
    charts[c].y_label = "median |found/true - 1|, median over truths";
    charts[c].log_y = true;
  }
  std::vector<std::pair<std::string, double>> kinds;  // in the order measured
  for (const FitScore& f : fits) {
    const std::pair kind(f.way, f.noise);
    if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) kinds.push_back(kind);
  }
  for (const auto& [light, noise] : kinds) {
    std::vector<double> patches, single, chi2, solves, work;
    std::array<std::vector<std::vector<double>>, 2> by_depth;
    for (const FitScore& f : fits) {
      if (f.way != light || f.noise != noise) continue;
      patches.push_back(f.patches_error);
      single.push_back(f.single_error);
      chi2.push_back(f.chi2);
      solves.push_back(f.solves);
      work.push_back(f.work);
      by_depth[0].resize(f.depth.kappa.size());
      by_depth[1].resize(f.depth.mu.size());
      for (std::size_t d = 0; d < f.depth.kappa.size(); ++d) {
        by_depth[0][d].push_back(f.depth.kappa[d]);
        by_depth[1][d].push_back(f.depth.mu[d]);
      }
    }
    table << "| " << light << " | " << text("%g %%", 100.0 * noise) << " | " << patches.size()
          << " | " << scientific(median(patches)) << ", " << scientific(worst(patches)) << " | "
          << scientific(median(single)) << ", " << scientific(worst(single)) << " | "
          << text("%.2f", worst(chi2)) << " | " << text("%.0f", median(solves)) << " | "
          << text("%.0f", median(work)) << " |\n";
    for (std::size_t c = 0; c < 2; ++c) {
      Series series;
      series.label = light + ", noise " + text("%g %%", 100.0 * noise);
      for (std::size_t d = 0; d < by_depth[c].size(); ++d) {
        series.x.push_back(static_cast<double>(d) + 1.0);
        series.y.push_back(median(by_depth[c][d]));
      }
      charts[c].series.push_back(std::move(series));
    }
  }
  draw(charts, png, 2, 700, 480);
  return table.str();
}

/// Medians over the truths of a light and a number of images.
std::string draw_patterns(const Fits& fits, const fs::path& png) {
  std::ostringstream table;
  table << "| light | images | E, 8 × 8 patches | E, single voxels | κ off by | μ off by | χ² | "
           "solves "
           "|\n|---|---|---|---|---|---|---|---|\n";
  std::vector<Chart> charts(2);
  charts[0].title = "8 x 8 patches";
  charts[1].title = "single voxels";
  for (Chart& chart : charts) {
    chart.title = "E under " + chart.title + ", noise 1 %";
    chart.x_label = "images";
    chart.y_label = "E, median";
    chart.log_x = chart.log_y = true;
  }
  std::vector<std::pair<std::string, int>> kinds;  // in the order measured
  std::map<std::pair<std::string, int>, Fits> by_kind;
  for (const FitScore& f : fits) {
    Fits& same = by_kind[{f.way, f.patterns}];
    if (same.empty()) kinds.emplace_back(f.way, f.patterns);
    same.push_back(f);
  }
  const auto of = [](const Fits& same, const auto& value) {
    std::vector<double> values;
    for (const FitScore& f : same) values.push_back(value(f));
    return median(std::move(values));
  };
  for (const auto& kind : kinds) {
    const Fits& same = by_kind.at(kind);
    const std::array<double, 2> error{of(same, [](const FitScore& f) { return f.patches_error; }),
                                      of(same, [](const FitScore& f) { return f.single_error; })};
    table << "| " << kind.first << " | " << kind.second << " | " << scientific(error[0]) << " | "
          << scientific(error[1]) << " | "
          << text("%.0f %%",
                  100.0 * of(same, [](const FitScore& f) { return median(f.depth.kappa); }))
          << " | "
          << text("%.0f %%", 100.0 * of(same, [](const FitScore& f) { return median(f.depth.mu); }))
          << " | " << text("%.2f", of(same, [](const FitScore& f) { return f.chi2; })) << " | "
          << text("%.0f", of(same, [](const FitScore& f) { return f.solves; })) << " |\n";
    for (std::size_t c = 0; c < charts.size(); ++c) {
      std::vector<Series>& series = charts[c].series;
      if (series.empty() || series.back().label != kind.first) series.push_back(line(kind.first));
      series.back().x.push_back(kind.second);
      series.back().y.push_back(error[c]);
    }
  }
  draw(charts, png, 2, 700, 480);
  return table.str();
}

std::string draw_voxels(const Fits& fits, const fs::path& png) {
  std::ostringstream table;
  table << "| grid | seconds | solves | work | microseconds per voxel | E, 8 × 8 patches |\n"
           "|---|---|---|---|---|---|\n";
  std::vector<Chart> charts(2);
  charts[0].title = "one channel, 16 patterns, noise 1 %";
  charts[0].y_label = "seconds";
  charts[1].title = "what it costs in solves";
  charts[1].y_label = "batched solves, all grids";
  for (Chart& chart : charts) {
    chart.x_label = "voxels";
    chart.log_x = chart.log_y = true;
    chart.series.push_back(line(""));
  }
  for (const FitScore& f : fits) {
    const auto voxels = static_cast<double>(f.grid.cells());
    table << "| " << grid_name(f.grid) << " | " << text("%.1f", f.seconds) << " | " << f.solves
          << " | " << text("%.0f", f.work) << " | " << text("%.0f", 1e6 * f.seconds / voxels)
          << " | " << scientific(f.patches_error) << " |\n";
    for (Chart& chart : charts) chart.series[0].x.push_back(voxels);
    charts[0].series[0].y.push_back(f.seconds);
    charts[1].series[0].y.push_back(f.solves);
  }
  draw(charts, png, 2, 600, 460);
  return table.str();
}

std::string draw_monte_carlo(const Json& record, const fs::path& png) {
  const PhotonFit fit = photon_fit_from_json(record.at("fits").at(0));
  const FitScore& f = fit.score;
  std::ostringstream table;
  table << "| grid | χ² | E of the fitted volume | E of the true coefficients under diffusion | κ "
           "off, "
           "two layers at the seen face | μ off |\n|---|---|---|---|---|---|\n| "
        << grid_name(f.grid) << " | " << text("%.2f", f.chi2) << " | "
        << scientific(f.patches_error) << " | " << scientific(fit.truth_error) << " | ";
  const std::size_t n = f.depth.kappa.size();
  table << text("%.0f", 100.0 * f.depth.kappa[n - 1]) << ", "
        << text("%.0f", 100.0 * f.depth.kappa[n - 2]) << " % | "
        << text("%.0f", 100.0 * f.depth.mu[n - 1]) << ", "
        << text("%.0f", 100.0 * f.depth.mu[n - 2]) << " % |\n";
  Chart chart;
  chart.title = "data from Monte Carlo";
  chart.x_label = "layer, 1 = lit face";
  chart.y_label = "median |found/true - 1|";
  chart.log_y = true;
  Series kappa = line("κ");
  Series mu = line("μ");
  for (std::size_t d = 0; d < n; ++d) {
    for (Series* s : {&kappa, &mu}) s->x.push_back(static_cast<double>(d) + 1.0);
    kappa.y.push_back(f.depth.kappa[d]);
    mu.y.push_back(f.depth.mu[d]);
  }
  chart.series = {kappa, mu};
  draw(std::vector<Chart>{chart}, png, 1, 700, 480);
  return table.str();
}

}  // namespace

void draw_inverse(const fs::path& folder) {
  for (const std::string& section : inverse_sections()) {
    const fs::path file = folder / ("inverse-" + section + ".json");
    if (!fs::exists(file)) continue;
    const Json record = read_record(file, "inverse");
    const fs::path png = folder / ("bench-inverse-" + section + ".png");
    std::string table;
    if (section == "samples") {
      table = sample_table(record.at("fits"));
    } else if (section == "montecarlo") {
      table = draw_monte_carlo(record, png);
    } else {
      using Draw = std::string (*)(const Fits&, const fs::path&);
      static const std::map<std::string, Draw> drawings{{"optimisers", draw_optimisers},
                                                        {"scores", draw_scores},
                                                        {"embedded", draw_scores},
                                                        {"patterns", draw_patterns},
                                                        {"voxels", draw_voxels}};
      table = drawings.at(section)(fits_of(record), png);
    }
    io::write_text_atomically(folder / ("table-inverse-" + section + ".md"),
                              provenance(record) + table);
  }
}

}  // namespace kappamu::bench
