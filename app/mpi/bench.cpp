#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/mpi/commands.h"
#include "core/process_memory.h"
#include "core/processor_time.h"
#include "forward/distributed/distributed_solver.h"

namespace kappamu::app::mpi {

namespace {

using namespace forward;
using namespace forward::distributed;
using Json = nlohmann::ordered_json;

struct BenchArguments {
  std::array<int, 3> grid{64, 64, 64};
  double contrast = 100.0;
  int patterns = 4;
  double tolerance = 1e-6;
};

/// A block of 16 mm whose cells of 1 mm scatter strongly or weakly, by chance, the same on any grid
/// and any number of ranks.
void set_cells(const BlockPieces& pieces, double contrast, std::vector<double>& kappa,
               std::vector<double>& mu) {
  constexpr int cells = 16;
  const GridShape& whole = pieces.whole().shape;
  const GridShape& piece = pieces.piece().shape;
  const Box& held = pieces.held();
  kappa.resize(piece.cells());
  mu.assign(piece.cells(), 0.005);
  std::size_t i = 0;
  for (int z = held.begin[2]; z < held.end[2]; ++z) {
    for (int y = held.begin[1]; y < held.end[1]; ++y) {
      for (int x = held.begin[0]; x < held.end[0]; ++x, ++i) {
        const auto cell = [&](int at, int extent) {
          return static_cast<unsigned>(static_cast<long>(at) * cells / extent);
        };
        unsigned hash = cell(x, whole.nx) + cells * (cell(y, whole.ny) + cells * cell(z, whole.nz));
        hash = (hash ^ (hash >> 7) ^ 0x9E3779B9U) * 0x85EBCA6BU;
        hash = (hash ^ (hash >> 13)) * 0xC2B2AE35U;
        kappa[i] = (hash >> 17 & 1U) != 0 ? 0.5 : 0.5 / contrast;
      }
    }
  }
}

/// Seconds of a message of `bytes` to another rank, and of a sum over all ranks; 0 on one rank.
double message_seconds(MPI_Comm comm, std::size_t bytes) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  if (ranks == 1) return 0.0;
  constexpr int rounds = 200;
  std::vector<char> buffer(bytes);
  const int count = static_cast<int>(bytes);
  MPI_Barrier(comm);
  const double begin = MPI_Wtime();
  for (int i = 0; i < rounds && rank < 2; ++i) {
    if ((rank == 0) == (i % 2 == 0)) {
      MPI_Send(buffer.data(), count, MPI_CHAR, 1 - rank, 0, comm);
    } else {
      MPI_Recv(buffer.data(), count, MPI_CHAR, 1 - rank, 0, comm, MPI_STATUS_IGNORE);
    }
  }
  double seconds = (MPI_Wtime() - begin) / rounds;
  MPI_Bcast(&seconds, 1, MPI_DOUBLE, 0, comm);
  return seconds;
}
double sum_seconds(const BlockPieces& pieces) {
  constexpr int rounds = 200;
  MPI_Barrier(pieces.comm());
  const double begin = MPI_Wtime();
  for (int i = 0; i < rounds; ++i) pieces.sum(1.0);
  return (MPI_Wtime() - begin) / rounds;
}

void run_bench(const BenchArguments& arguments, Globals& globals) {
  const auto [nx, ny, nz] = arguments.grid;
  GridSetup setup;
  setup.shape = {nx, ny, nz, 16.0 / nx};
  const auto pieces = std::make_shared<BlockPieces>(MPI_COMM_WORLD, setup);
  const auto solver = make_distributed_solver(pieces);
  std::vector<double> kappa, mu;
  set_cells(*pieces, arguments.contrast, kappa, mu);
  Stopwatch assembly;
  solver->set_medium(kappa, mu);
  const double setup_seconds = assembly.seconds();

  const FaceShape face = face_shape(pieces->piece().shape, setup.lit_face);
  std::vector<double> light(static_cast<std::size_t>(arguments.patterns) * face.cells());
  for (std::size_t k = 0; k < light.size(); ++k) {
    const std::size_t m = k / face.cells();
    const int u = static_cast<int>(k % face.cells()) % face.nu + pieces->held().begin[0];
    light[k] = (u * (static_cast<int>(m) + 1) * 4 / nx) % 2 == 0 ? 1.0 : 0.0;
  }
  const auto b = solver->make_field(arguments.patterns),
             phi = solver->make_field(arguments.patterns);
  solver->light_source(light, *b);
  double processor = -processor_seconds();
  const SolveReport report = solver->solve(*b, *phi, {arguments.tolerance, 500});
  processor = pieces->sum(processor + processor_seconds()) / arguments.patterns;

  std::vector<double> memory(static_cast<std::size_t>(pieces->ranks()));
  const double mine = peak_memory();
  MPI_Allgather(&mine, 1, MPI_DOUBLE, memory.data(), 1, MPI_DOUBLE, pieces->comm());
  constexpr std::size_t long_message = 1 << 20;
  const double latency = message_seconds(pieces->comm(), 8);
  const double of_long = message_seconds(pieces->comm(), long_message);
  const double reduction = sum_seconds(*pieces);
  if (pieces->rank() != 0) return;
  const double voxels = static_cast<double>(setup.shape.cells());
  const double per_light = report.seconds / arguments.patterns;
  const double most = *std::max_element(memory.begin(), memory.end());
  if (globals.json) {
    const Json json{{"grid", arguments.grid},
                    {"ranks", pieces->ranks()},
                    {"contrast", arguments.contrast},
                    {"iterations", report.iterations},
                    {"setup_seconds", setup_seconds},
                    {"seconds_per_pattern", per_light},
                    {"processor_seconds_per_pattern", processor},
                    {"memory_peak_bytes", memory},
                    {"message_seconds", latency},
                    {"bytes_per_second", of_long > 0.0 ? long_message / of_long : 0.0},
                    {"sum_seconds", reduction}};
    std::printf("%s\n", json.dump().c_str());
    return;
  }
  std::printf(
      "%d x %d x %d, %d ranks: %s, set-up %.2f s, %.3f s per pattern (%.3f s of "
      "all processors), at most %.0f MB a rank (%.0f "
      "bytes a voxel); message %.1f us, %.2f GB/s, sum %.1f us\n",
      nx, ny, nz, pieces->ranks(), report.message.c_str(), setup_seconds, per_light, processor,
      most / 1e6, most * pieces->ranks() / voxels, 1e6 * latency,
      of_long > 0.0 ? 1e-9 * long_message / of_long : 0.0, 1e6 * reduction);
}

}  // namespace

void add_bench(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "bench", "Time solves of a block of cells, with what they cost in memory and messages.");
  auto options = std::make_shared<BenchArguments>();
  command->add_option("--grid", options->grid, "Voxels along x, y and z (default 64,64,64)")
      ->delimiter(',');
  command->add_option("--contrast", options->contrast, "Largest kappa over smallest (default 100)");
  command->add_option("--patterns", options->patterns, "Light patterns (default 4)")
      ->check(CLI::PositiveNumber);
  command->add_option("--tolerance", options->tolerance, "Relative residual (default 1e-6)");
  command->callback([options, &globals] { run_bench(*options, globals); });
}

}  // namespace kappamu::app::mpi
