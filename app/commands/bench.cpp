// `kappamu bench`: the measurements behind docs/benchmarks.md, one subcommand per subject.
#include <CLI/CLI.hpp>

#include "app/bench_command.h"
#include "app/command.h"

namespace kappamu::app {

void add_bench(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "bench",
      "Measure speed and accuracy, and draw the charts of docs/benchmarks.md.\n\n"
      "Every subcommand writes its raw numbers as JSON (machine, device, build, repetitions) and\n"
      "its charts as PNG, each beside the gnuplot script that drew it, into the folder of -o.\n"
      "scripts/bench.sh runs them all and renews docs/benchmarks.md.");
  command->require_subcommand(1);
  command->fallthrough();
  add_bench_calibration(*command, globals);
  add_bench_choices(*command, globals);
  add_bench_forward(*command, globals);
  add_bench_hdr(*command, globals);
  add_bench_inverse(*command, globals);
  add_bench_limits(*command, globals);
  add_bench_rig(*command, globals);
  add_bench_slabs(*command, globals);
  add_bench_uncertainty(*command, globals);
  add_bench_validity(*command, globals);
}

}  // namespace kappamu::app
