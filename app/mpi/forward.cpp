#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/forward_output.h"
#include "app/mpi/commands.h"
#include "app/mpi/npy_parts.h"
#include "app/mpi/piece_warnings.h"
#include "app/options/block_options.h"
#include "core/error.h"
#include "core/file_name.h"
#include "core/numbers/coefficient_bounds.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "forward/distributed/distributed_solver.h"
#include "forward/distributed/together.h"
#include "forward/grid/grid_physics.h"
#include "forward/grid/solve_verdict.h"
#include "io/atomic_file.h"
#include "pipeline/output_folder.h"
#include "pipeline/verify.h"

namespace kappamu::app::mpi {

namespace {

namespace fs = std::filesystem;
using namespace forward;
using namespace forward::distributed;

constexpr int patterns_at_once = 16;

struct ForwardArguments {
  std::string kappa, mu, irradiance, out;
  double voxel = 0.0;
  BlockOptions block;
  SolveOptions solve;
};

GridSetup setup_of(const ForwardArguments& arguments) {
  for (const std::string& file : {arguments.kappa, arguments.mu, arguments.irradiance}) {
    if (lower_extension(file) != ".npy") {
      throw InputError(file +
                       ": only .npy arrays are read by parts; write one with `kappamu "
                       "export --format npy`");
    }
  }
  const auto shape = npy_shape(MPI_COMM_WORLD, arguments.kappa);
  if (shape.size() != 3 || shape[0] * shape[1] * shape[2] == 0) {
    throw InputError(arguments.kappa + ": kappa must be an array [z][y][x]");
  }
  return arguments.block.setup({static_cast<int>(shape[2]), static_cast<int>(shape[1]),
                                static_cast<int>(shape[0]), arguments.voxel});
}

/// Of the piece, halo included.
Medium read_medium(const BlockPieces& pieces, const ForwardArguments& arguments) {
  const Part part = volume_part(pieces.whole().shape, pieces.held());
  const GridShape& shape = pieces.piece().shape;
  Medium medium{{shape, read_part(pieces.comm(), arguments.kappa, part)},
                {shape, read_part(pieces.comm(), arguments.mu, part)}};
  together(pieces.comm(), [&] {
    const auto& first = pieces.held().begin;
    const auto require = [&](const Volume<double>& volume, const std::string& file, double least,
                             const char* rule) {
      for (std::size_t i = 0; i < volume.size(); ++i) {
        const double value = volume[i];
        if (value >= least && value <= most_coefficient) continue;
        const auto nx = static_cast<std::size_t>(shape.nx), ny = static_cast<std::size_t>(shape.ny);
        throw InputError(file + formatted(": %g at voxel x=%zu y=%zu z=%zu; it must be %s", value,
                                          i % nx + first[0], i / nx % ny + first[1],
                                          i / nx / ny + first[2], rule));
      }
    };
    require(medium.kappa, arguments.kappa, least_kappa, "positive, from 1e-9 to 1e9 mm");
    require(medium.mu, arguments.mu, 0.0, "finite and not negative, at most 1e9 /mm");
  });
  return medium;
}

/// [M][v][u] of the piece's lit face; 0 on its halo, which is another rank's.
std::vector<double> read_light(const BlockPieces& pieces, const std::string& file, int& patterns) {
  const Face lit = pieces.whole().lit_face;
  const auto shape = npy_shape(pieces.comm(), file);
  patterns = shape.size() == 3 ? static_cast<int>(shape[0]) : 1;
  std::vector<double> light =
      read_part(pieces.comm(), file, face_part(pieces.whole().shape, lit, patterns, pieces.held()));
  together(pieces.comm(), [&] {
    for (const double e : light) {
      if (std::isfinite(e) && e >= 0.0) continue;
      throw InputError(file + ": an irradiance is " + shown_number(e, "%g") +
                       "; it must be finite and not negative");
    }
  });
  const double brightest = light.empty() ? 0.0 : *std::max_element(light.begin(), light.end());
  require_usual_light(static_cast<float>(largest(pieces.comm(), brightest)), file);
  const FaceShape face = face_shape(pieces.piece().shape, lit);
  for (std::size_t k = 0; k < light.size(); ++k) {
    const int in_face = static_cast<int>(k % face.cells());
    if (!pieces.owns_pixel(lit, in_face % face.nu, in_face / face.nu)) light[k] = 0.0;
  }
  return light;
}

/// The rank's own pixels of maps of its piece's face.
std::vector<float> own_pixels(const BlockPieces& pieces, Face face,
                              const std::vector<double>& maps) {
  const FaceShape shape = face_shape(pieces.piece().shape, face);
  std::vector<float> own;
  for (std::size_t k = 0; k < maps.size(); ++k) {
    const int in_face = static_cast<int>(k % shape.cells());
    if (pieces.owns_pixel(face, in_face % shape.nu, in_face / shape.nu)) {
      own.push_back(static_cast<float>(maps[k]));
    }
  }
  return own;
}

/// Solves and writes the maps, some patterns at a time; the powers of all ranks together.
ForwardResult solve(const BlockPieces& pieces, GridSolver& solver, const Medium& medium,
                    const std::vector<double>& light, int patterns, const SolveOptions& options,
                    std::array<std::vector<double>, 6>& exitance) {
  ForwardResult result;
  SolveReport report;
  const std::size_t lit = face_shape(pieces.piece().shape, pieces.whole().lit_face).cells();
  for (int begin = 0; begin < patterns; begin += patterns_at_once) {
    const int count = std::min(patterns_at_once, patterns - begin);
    const auto part = std::span(light).subspan(static_cast<std::size_t>(begin) * lit,
                                               static_cast<std::size_t>(count) * lit);
    const auto b = solver.make_field(count), phi = solver.make_field(count);
    solver.light_source(part, *b);
    const SolveReport one = solver.solve(*b, *phi, options);
    report.iterations = std::max(report.iterations, one.iterations);
    report.seconds += one.seconds;
    report.residual.insert(report.residual.end(), one.residual.begin(), one.residual.end());
    if (one.termination == Termination::failed) break;
    std::array<std::vector<double>, 6> maps;
    for (const Face face : all_faces) {
      auto& map = maps[static_cast<std::size_t>(face)];
      map.resize(static_cast<std::size_t>(count) * face_shape(pieces.piece().shape, face).cells());
      solver.exitance(*phi, face, face == pieces.whole().lit_face ? part : part.first(0), map);
      auto& all = exitance[static_cast<std::size_t>(face)];
      all.insert(all.end(), map.begin(), map.end());
    }
    for (PowerBalance& balance : power_balance(solver, medium, *phi, part, maps)) {
      std::array<double, 9> sums{balance.entering, balance.unscattered, balance.absorbed};
      std::copy(balance.exiting.begin(), balance.exiting.end(), sums.begin() + 3);
      pieces.sum(sums);
      balance = {sums[0], {}, sums[1], sums[2]};
      std::copy(sums.begin() + 3, sums.end(), balance.exiting.begin());
      result.balance.push_back(balance);
    }
  }
  conclude(report, options.tolerance, report.iterations < options.max_iterations,
           Precision::double_precision);
  result.backend = solver.backend();
  result.termination = report.termination;
  result.message = report.message;
  result.iterations = report.iterations;
  result.seconds = report.seconds;
  result.residual = report.residual;
  return result;
}

void print(const Globals& globals, const nlohmann::ordered_json& summary, const ForwardRun& run,
           const ForwardResult& result, const std::vector<std::string>& warnings,
           const fs::path& out) {
  for (const std::string& warning : warnings) {
    std::fprintf(stderr, "kappamu-mpi: %s\n", shown_text(warning).c_str());
  }
  if (globals.json) {
    std::printf("%s\n", summary.dump().c_str());
    return;
  }
  const GridShape& s = run.setup.shape;
  std::printf("%d pattern%s on %d x %d x %d voxels by %s: %s, %.2f s\n%s\n", run.patterns,
              run.patterns == 1 ? "" : "s", s.nx, s.ny, s.nz, result.backend.c_str(),
              result.message.c_str(), result.seconds, (out / "summary.json").c_str());
}

void run_forward(const ForwardArguments& arguments, Globals& globals) {
  const MPI_Comm comm = MPI_COMM_WORLD;
  const std::vector<fs::path> inputs{arguments.kappa, arguments.mu, arguments.irradiance};
  on_first(comm, [&] { pipeline::require_as_written(inputs); });
  const GridSetup setup = setup_of(arguments);
  validate(setup);
  require_usual_voxel(setup.shape.voxel_mm, arguments.kappa);
  const auto pieces = std::make_shared<BlockPieces>(comm, setup);
  const Medium medium = read_medium(*pieces, arguments);
  ForwardRun run{"multigrid", setup, {}, 1};
  run.options.solve = arguments.solve;
  const std::vector<double> light = read_light(*pieces, arguments.irradiance, run.patterns);

  std::unique_ptr<pipeline::OutputFolder> out;
  on_first(comm, [&] {
    out = std::make_unique<pipeline::OutputFolder>(arguments.out, "forward", inputs,
                                                   forward_outputs());
  });
  const fs::path partial = shared(comm, out ? out->partial().string() : std::string());
  const auto solver = make_distributed_solver(pieces);
  const Stopwatch watch;
  solver->set_medium(medium.kappa.values(), medium.mu.values());
  const double setup_seconds = watch.seconds();
  std::array<std::vector<double>, 6> exitance;
  ForwardResult result =
      solve(*pieces, *solver, medium, light, run.patterns, arguments.solve, exitance);
  result.setup_seconds = setup_seconds;
  if (result.termination == Termination::failed) throw InputError(result.message);
  for (const Face face : all_faces) {
    write_part(comm, partial / ("exitance_" + to_string(face) + ".npy"),
               face_part(setup.shape, face, run.patterns, pieces->owned(), true),
               std::span<const float>(
                   own_pixels(*pieces, face, exitance[static_cast<std::size_t>(face)])));
  }
  std::vector<std::string> warnings =
      piece_warnings(*pieces, medium.kappa.values(), medium.mu.values());
  on_first(comm, [&] {
    const nlohmann::ordered_json summary = forward_summary(run, result);
    io::write_text_atomically(partial / "summary.json", summary.dump(2) + "\n");
    out->commit();
    if (result.termination != Termination::converged) {
      warnings.push_back("not converged: " + result.message + "; the outputs are kept and marked");
    }
    print(globals, summary, run, result, warnings, arguments.out);
  });
  if (result.termination != Termination::converged) globals.exit_code = 3;
}

}  // namespace

void add_forward(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "forward",
      R"(Predict the light that leaves a block of known coefficients, cut between the ranks.

Reads and writes what `kappamu forward` does, .npy arrays alone, by the method multigrid.)");
  auto options = std::make_shared<ForwardArguments>();
  command->add_option("--kappa", options->kappa, "Diffusion coefficient [mm], .npy [z][y][x]")
      ->required();
  command->add_option("--mu", options->mu, "Absorption coefficient [1/mm], .npy [z][y][x]")
      ->required();
  command->add_option("--irradiance", options->irradiance, "Light on the lit face, .npy [M][v][u]")
      ->required();
  command->add_option("--voxel", options->voxel, "Voxel edge [mm]")
      ->required()
      ->check(CLI::PositiveNumber);
  command->add_option("-o,--out", options->out, "Folder for the maps; made if missing")->required();
  add_block_options(*command, options->block, options->solve);
  command->callback([options, &globals] { run_forward(*options, globals); });
}

}  // namespace kappamu::app::mpi
