#include "studies/forward/peer_runner.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>

#include "core/error.h"
#include "core/shown_text.h"
#include "studies/record.h"

namespace kappamu::studies {

namespace {

namespace fs = std::filesystem;

#ifdef KAPPAMU_PEERS_PROGRAM
constexpr const char* peers_program = KAPPAMU_PEERS_PROGRAM;
#else
constexpr const char* peers_program = "";
#endif

struct Ended {
  int status = 0;
  std::string output;
};

Ended run(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {127, ""};
  Ended ended;
  char part[4096];
  while (const std::size_t got = std::fread(part, 1, sizeof part, pipe))
    ended.output.append(part, got);
  const int status = pclose(pipe);
  ended.status = WIFEXITED(status) ? WEXITSTATUS(status) : 127;
  return ended;
}

std::string quoted(const std::string& word) {
  std::string result = "'";
  for (const char c : word) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

void write_raw(const fs::path& file, std::span<const double> values) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(values.data()),
            static_cast<std::streamsize>(values.size_bytes()));
  if (!out.flush()) throw InputError("cannot write " + file.string() + "; is the disk full?");
}

std::vector<double> read_raw(const fs::path& file, std::size_t count) {
  std::ifstream in(file, std::ios::binary);
  std::vector<double> values(count);
  in.read(reinterpret_cast<char*>(values.data()),
          static_cast<std::streamsize>(count * sizeof(double)));
  if (!in) throw InputError("cannot read " + file.string() + "; did the peer fail?");
  return values;
}

/// mpirun as this user may call it; processes bound to no core, so that ranks never share one.
std::string launcher(int ranks) {
  return "mpirun --oversubscribe --bind-to none " +
         std::string(geteuid() == 0 ? "--allow-run-as-root " : "") + "-n " + std::to_string(ranks) +
         " ";
}

void write_problem(const Problem& problem, int patterns, const fs::path& folder) {
  fs::create_directories(folder);
  const forward::GridSetup& setup = problem.setup();
  const auto matrix = assemble(setup, problem.constants(), problem.medium());
  std::ofstream(folder / "problem.txt") << setup.shape.nx << ' ' << setup.shape.ny << ' '
                                        << setup.shape.nz << ' ' << patterns << '\n';
  write_raw(folder / "link_x.bin", matrix.link[0]);
  write_raw(folder / "link_y.bin", matrix.link[1]);
  write_raw(folder / "link_z.bin", matrix.link[2]);
  write_raw(folder / "diagonal.bin", matrix.diagonal);
  write_raw(folder / "rhs.bin", problem.right_hand_sides(patterns));
}

}  // namespace

bool has_peer() {
  return *peers_program != '\0' && access(peers_program, X_OK) == 0 &&
         run("mpirun --version 2>/dev/null").status == 0;
}

PeerRun run_peer(const Problem& problem, int patterns, const std::vector<double>& tolerances,
                 int repetitions, const fs::path& folder) {
  write_problem(problem, patterns, folder);
  PeerRun result;
  result.ranks = usable_cores();
  std::string command = "OMP_NUM_THREADS=1 " + launcher(result.ranks) + quoted(peers_program) +
                        " " + quoted(folder.string()) + " " + std::to_string(repetitions);
  for (const double tolerance : tolerances) {
    command += shown_number(tolerance, " %g");
  }
  const fs::path errors = folder / "stderr.txt";
  const Ended ended = run(command + " 2>" + quoted(errors.string()));
  if (ended.status != 0) {
    throw InputError(std::string(peer_name) + " failed with exit code " +
                     std::to_string(ended.status) + "; its words are in " + errors.string() + ".");
  }
  std::istringstream lines(ended.output);
  for (std::string line; std::getline(lines, line);) {
    const auto object = nlohmann::json::parse(line, nullptr, false);
    if (!object.is_object() || !object.contains("trial")) continue;
    const auto setting = object.at("setting").get<std::string>();
    if (object.at("trial").get<bool>()) {
      char text[160];
      std::snprintf(text, sizeof text, "%s: set-up %.3f s, solve %.3f s, %d iterations",
                    setting.c_str(), object.at("set_up_seconds").get<double>(),
                    object.at("solve_seconds").get<double>(), object.at("iterations").get<int>());
      result.trials.emplace_back(text);
      continue;
    }
    Sample sample;
    sample.method = peer_name;
    sample.precision = "double";
    sample.setting = result.setting = setting;
    sample.tolerance = object.at("tolerance").get<double>();
    sample.patterns = patterns;
    sample.iterations = object.at("iterations").get<int>();
    sample.set_up_seconds = object.at("set_up_seconds").get<double>();
    sample.solve_seconds_per_rhs = object.at("solve_seconds_per_rhs").get<double>();
    sample.seconds_per_rhs =
        sample.solve_seconds_per_rhs + sample.set_up_seconds / problem.spec().patterns;
    const fs::path file = folder / ("phi_" + std::to_string(result.samples.size()) + ".bin");
    const Errors found = problem.errors_of(
        read_raw(file, problem.setup().shape.cells() * static_cast<std::size_t>(patterns)),
        patterns);
    sample.phi_error = found.phi;
    sample.map_error = found.maps;
    sample.converged = true;  // the true error says how far
    result.samples.push_back(sample);
  }
  fs::remove_all(folder);
  if (result.samples.size() != tolerances.size()) {
    throw InputError(std::string(peer_name) + " reported " + std::to_string(result.samples.size()) +
                     " of " + std::to_string(tolerances.size()) + " tolerances.");
  }
  return result;
}

}  // namespace kappamu::studies
