// kappamu-peers FOLDER REPETITIONS TOLERANCE...: solves a problem that `kappamu-studies` assembled
// with hypre's PFMG, and reports as lines of JSON what it took. Started by the bench through
// mpirun. Every setting is tried on the first pattern at residual 1e-6; the one with the least
// set-up/16 + solve goes on to all tolerances and patterns. The φ of tolerance number n is written
// to FOLDER/phi_<n>.bin, doubles [pattern][z][y][x].
#include <HYPRE_utilities.h>
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "studies/peers/pfmg.h"

namespace kappamu::peers {

namespace {

/// Wall time of `work` on the slowest rank.
double timed(const std::function<void()>& work) {
  MPI_Barrier(MPI_COMM_WORLD);
  const auto start = std::chrono::steady_clock::now();
  work();
  MPI_Barrier(MPI_COMM_WORLD);
  double mine = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  double slowest = 0.0;
  MPI_Allreduce(&mine, &slowest, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  return slowest;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

class Run {
 public:
  Run(std::string folder, int repetitions)
      : folder_(std::move(folder)),
        repetitions_(repetitions),
        rank_(value_of(MPI_Comm_rank)),
        ranks_(value_of(MPI_Comm_size)),
        problem_(folder_, rank_, ranks_),
        peer_(problem_) {
    for (int m = 0; m < problem_.patterns(); ++m) rhs_.push_back(problem_.local_rhs(m));
  }

  void all(const std::vector<double>& tolerances) {
    const Setting& setting = settings[best_setting()];
    const double set_up = median(repeated([&] { peer_.set_up(setting); }));
    for (std::size_t t = 0; t < tolerances.size(); ++t)
      solve_all(t, tolerances[t], set_up, setting);
  }

 private:
  static int value_of(int (*query)(MPI_Comm, int*)) {
    int value = 0;
    query(MPI_COMM_WORLD, &value);
    return value;
  }

  std::vector<double> repeated(const std::function<void()>& work) const {
    std::vector<double> seconds;
    for (int r = 0; r < repetitions_; ++r) seconds.push_back(timed(work));
    return seconds;
  }

  std::size_t best_setting() {
    constexpr double shared_by = 16.0, tolerance = 1e-6;
    std::uint64_t best = 0;
    double least = 0.0;
    for (std::size_t s = 0; s < settings.size(); ++s) {
      const double set_up = timed([&] { peer_.set_up(settings[s]); });
      int iterations = 0;
      std::vector<double> phi;
      const double solve = timed([&] { iterations = peer_.solve(rhs_[0], tolerance, phi); });
      const double cost = set_up / shared_by + solve;
      if (rank_ == 0) {
        std::printf(
            "{\"setting\": \"%s\", \"set_up_seconds\": %.6g, \"solve_seconds\": %.6g, "
            "\"iterations\": %d, \"trial\": true}\n",
            settings[s].name, set_up, solve, iterations);
      }
      // A setting that fails to converge has no claim, however quick.
      if (iterations < max_iterations && (s == 0 || cost < least || least == 0.0)) {
        best = s;
        least = cost;
      }
    }
    MPI_Bcast(&best, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    return best;
  }

  void solve_all(std::size_t number, double tolerance, double set_up, const Setting& setting) {
    std::vector<std::vector<double>> phi(rhs_.size());
    double seconds = 0.0;
    int iterations = 0;
    for (std::size_t m = 0; m < rhs_.size(); ++m) {
      int needed = 0;
      seconds += median(repeated([&] { needed = peer_.solve(rhs_[m], tolerance, phi[m]); }));
      iterations = std::max(iterations, needed);
    }
    write(number, phi);
    if (rank_ == 0) {
      std::printf(
          "{\"setting\": \"%s\", \"tolerance\": %g, \"iterations\": %d, "
          "\"set_up_seconds\": %.6g, \"solve_seconds_per_rhs\": %.6g, \"ranks\": %d, "
          "\"trial\": false}\n",
          setting.name, tolerance, iterations, set_up, seconds / static_cast<double>(rhs_.size()),
          ranks_);
    }
  }

  /// Every rank's cells gathered to rank 0, which puts them in the bench's order.
  void write(std::size_t number, const std::vector<std::vector<double>>& phi) {
    std::vector<int> counts(static_cast<std::size_t>(ranks_)), offsets(counts.size(), 0);
    const int mine = problem_.local_rows();
    MPI_Gather(&mine, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
    for (std::size_t r = 1; r < counts.size(); ++r) offsets[r] = offsets[r - 1] + counts[r - 1];
    const std::string path = folder_ + "/phi_" + std::to_string(number) + ".bin";
    std::FILE* file = rank_ == 0 ? std::fopen(path.c_str(), "wb") : nullptr;
    if (rank_ == 0 && file == nullptr) throw std::runtime_error("cannot write " + path);
    const auto cells = static_cast<std::size_t>(problem_.rows());
    for (const std::vector<double>& pattern : phi) {
      std::vector<double> rows(rank_ == 0 ? cells : 0), volume(rows.size());
      MPI_Gatherv(pattern.data(), mine, MPI_DOUBLE, rows.data(), counts.data(), offsets.data(),
                  MPI_DOUBLE, 0, MPI_COMM_WORLD);
      if (rank_ != 0) continue;
      for (std::size_t i = 0; i < cells; ++i) volume[problem_.cell(static_cast<int>(i))] = rows[i];
      if (std::fwrite(volume.data(), sizeof(double), cells, file) != cells) {
        throw std::runtime_error("cannot write " + path);
      }
    }
    if (file != nullptr) std::fclose(file);
  }

  std::string folder_;
  int repetitions_;
  int rank_, ranks_;
  Problem problem_;
  Pfmg peer_;
  std::vector<std::vector<double>> rhs_;
};

}  // namespace
}  // namespace kappamu::peers

int main(int argc, char** argv) {
  using namespace kappamu::peers;
  if (argc < 4) {
    std::fprintf(stderr, "usage: kappamu-peers FOLDER REPETITIONS TOLERANCE...\n");
    return 2;
  }
  MPI_Init(&argc, &argv);
  try {
    HYPRE_Init();
    std::vector<double> tolerances;
    for (int i = 3; i < argc; ++i) tolerances.push_back(std::stod(argv[i]));
    Run(argv[1], std::stoi(argv[2])).all(tolerances);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "kappamu-peers: %s\n", error.what());
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  MPI_Finalize();
  return 0;
}
