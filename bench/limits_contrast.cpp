// Contrast of κ: iterations, their growth with the grid, and what each precision can attain.
#include <array>

#include "bench/limit_case.h"
#include "bench/limits.h"

namespace kappamu::bench {

namespace {

using forward::Precision;

struct Material {
  const char* name;
  MediumSpec spec;
};

const std::vector<Material>& materials() {
  static const std::vector<Material> all{
      {"smooth", {.kind = MediumKind::smooth}},
      {"inclusions", {.kind = MediumKind::inclusions}},
      {"checkerboard, 1 voxel", {.kind = MediumKind::checkerboard}},
      {"checkerboard, 3 voxels", {.kind = MediumKind::checkerboard, .period = 3}},
      {"layers of 1 voxel across the light", {.kind = MediumKind::layers}},
      {"layers of 1 voxel along the light", {.kind = MediumKind::layers, .axis = 0}},
      {"random, 1 voxel", {.kind = MediumKind::random}},
      {"random, cubes of 3 voxels", {.kind = MediumKind::random, .period = 3}},
  };
  return all;
}

constexpr std::array<double, 4> contrasts{1.0, 1e1, 1e4, 1e6};

MediumSpec of_contrast(MediumSpec spec, double contrast) {
  spec.contrast = contrast;
  return spec;
}

std::string count_or_failure(const Record& record) {
  const std::string count = to_text(figure(record, "iterations"));
  return std::get<std::string>(figure(record, "ended")) == "converged" ? count : "not in " + count;
}

}  // namespace

LimitTable limit_contrast(const LimitsOptions& options, Progress& progress) {
  LimitTable table{.id = "contrast", .records = {}, .markdown = ""};
  for (const Material& material : materials()) {
    for (const double contrast : contrasts) {
      progress.update("contrast", 0.0, std::string(material.name) + " " + to_text(contrast));
      const LimitOutcome outcome = run_limit({.setup = {.shape = {48, 48, 20, 0.25}},
                                              .medium = of_contrast(material.spec, contrast),
                                              .patterns = 2,
                                              .options = {1e-6, 200},
                                              .device = options.device});
      table.records.push_back({{"κ", material.name},
                               {"contrast", contrast},
                               {"iterations", outcome.iterations},
                               {"true error", *outcome.true_error},
                               {"imbalance", outcome.imbalance},
                               {"ended", to_string(outcome.termination)}});
    }
  }
  table.markdown = cross_table(table.records, "κ", "contrast", [](const Record& record) {
    return count_or_failure(record) + " (" + to_text(figure(record, "true error")) + ")";
  });
  return table;
}

LimitTable limit_size(const LimitsOptions& options, Progress& progress) {
  LimitTable table{.id = "size", .records = {}, .markdown = ""};
  std::vector<int> edges{32, 64, 128};
  if (options.large) edges.push_back(256);
  for (const Material& material : materials()) {
    if (material.spec.kind == MediumKind::smooth) continue;
    for (const double contrast : {1e4, 1e6}) {
      for (const int n : edges) {
        const std::string name = std::string(material.name) + ", " + to_text(contrast);
        progress.update("size", 0.0, name + " " + std::to_string(n));
        const LimitOutcome outcome = run_limit({.setup = {.shape = {n, n, n, 16.0 / n}},
                                                .medium = of_contrast(material.spec, contrast),
                                                .options = {1e-6, 200},
                                                .device = options.device,
                                                .with_error = false});
        table.records.push_back({{"κ and contrast", name},
                                 {"grid", std::to_string(n) + "³"},
                                 {"iterations", outcome.iterations},
                                 {"ended", to_string(outcome.termination)}});
        // Where a small grid runs out, a larger one only takes longer to.
        if (outcome.termination != forward::Termination::converged) break;
      }
    }
  }
  table.markdown = cross_table(table.records, "κ and contrast", "grid", count_or_failure);
  return table;
}

LimitTable limit_floor(const LimitsOptions& options, Progress& progress) {
  LimitTable table{.id = "floor", .records = {}, .markdown = ""};
  constexpr double out_of_reach = 1e-16;
  for (const Material& material : materials()) {
    for (const double contrast : contrasts) {
      for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
        const bool single = precision == Precision::single_precision;
        progress.update("floor", 0.0, std::string(material.name) + " " + to_text(contrast));
        const LimitOutcome outcome = run_limit({.setup = {.shape = {32, 32, 20, 0.25}},
                                                .medium = of_contrast(material.spec, contrast),
                                                .options = {out_of_reach, 200},
                                                .precision = precision,
                                                .device = options.device});
        table.records.push_back({{"κ", material.name},
                                 {"contrast", contrast},
                                 {"precision", single ? "single" : "double"},
                                 {"true error", *outcome.true_error},
                                 {"residual", outcome.residual},
                                 {"iterations", outcome.iterations},
                                 {"message", outcome.message}});
      }
    }
  }
  // One cell for both precisions: a record of single is followed by its record of double.
  std::vector<Record> pairs;
  for (std::size_t i = 0; i + 1 < table.records.size(); i += 2) {
    pairs.push_back({table.records[i][0],
                     table.records[i][1],
                     {"single", figure(table.records[i], "true error")},
                     {"double", figure(table.records[i + 1], "true error")}});
  }
  table.markdown = cross_table(pairs, "κ", "contrast", [](const Record& record) {
    return to_text(figure(record, "single")) + " / " + to_text(figure(record, "double"));
  });
  return table;
}

}  // namespace kappamu::bench
