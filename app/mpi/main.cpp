// kappamu-mpi: forward and fit of blocks beyond one machine (docs/distributed.md).
#include <petscsys.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>
#include <sstream>

#include "app/mpi/commands.h"
#include "core/error.h"
#include "core/shown_text.h"

namespace {

using kappamu::app::mpi::Globals;

constexpr const char* about =
    R"(Forward solves and fits of blocks beyond one machine: mpirun -n RANKS kappamu-mpi COMMAND ...)";

/// All ranks fail together, where they can (together.h). What one alone has met, such as want of
/// memory, ends the others too.
[[noreturn]] void end_all(const std::exception& error) {
  const bool memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
  std::fprintf(stderr, "kappamu-mpi: %s\n",
               memory ? "out of memory; start more ranks, on more machines"
                      : kappamu::shown_text(error.what()).c_str());
  std::fflush(nullptr);
  MPI_Abort(MPI_COMM_WORLD, 1);
  std::abort();
}

int run(int argc, char** argv, int rank) {
  CLI::App app(about);
  app.require_subcommand(1);
  app.fallthrough();
  app.set_version_flag("--version", "kappamu-mpi 0.1.0");
  Globals globals;
  app.add_flag("--json", globals.json, "Make the last line on standard output one JSON object");
  kappamu::app::mpi::add_forward(app, globals);
  kappamu::app::mpi::add_fit(app, globals);
  kappamu::app::mpi::add_bench(app, globals);
  try {
    app.parse(argc, argv);
    return globals.exit_code;
  } catch (const CLI::ParseError& error) {
    std::ostringstream help, usage;
    const bool asked = app.exit(error, help, usage) == 0;
    if (rank == 0) {
      std::printf("%s", help.str().c_str());
      std::fprintf(stderr, "%s", usage.str().c_str());
    }
    return asked ? 0 : 2;
  } catch (const kappamu::InputError& error) {
    if (rank == 0) {
      std::fprintf(stderr, "kappamu-mpi: %s\n", kappamu::shown_text(error.what()).c_str());
    }
    return 1;
  } catch (const std::exception& error) {
    end_all(error);
  }
}

}  // namespace

int main(int argc, char** argv) {
  // A crash is the shell's to report, and PETSc's failures are exceptions here.
  PetscOptionsSetValue(nullptr, "-no_signal_handler", "true");
  if (PetscInitializeNoArguments() != 0) return 1;
  PetscPushErrorHandler(PetscIgnoreErrorHandler, nullptr);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const int code = run(argc, argv, rank);
  return PetscFinalize() == 0 ? code : 1;
}
