#include "studies/record.h"

#include <sched.h>
#include <sys/sysinfo.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/error.h"
#include "core/processor_time.h"
#include "io/atomic_file.h"

namespace kappamu::studies {

namespace {

constexpr int record_version = 2;

std::string cpu_model() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.rfind("model name", 0) != 0) continue;
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace

int usable_cores() {
  cpu_set_t set;
  return sched_getaffinity(0, sizeof set, &set) == 0
             ? CPU_COUNT(&set)
             : static_cast<int>(std::thread::hardware_concurrency());
}

double machine_load() {
  double loads[1] = {0.0};
  return getloadavg(loads, 1) == 1 ? loads[0] : 0.0;
}

double host_copy_bandwidth(int repetitions) {
  constexpr std::size_t bytes = std::size_t{1} << 27;  // four times the largest cache at hand
  std::vector<char> from(bytes, 1), to(bytes, 0);
  const auto cores = static_cast<std::size_t>(std::max(1, usable_cores()));
  double best = 0.0;
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    const Stopwatch watch;
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < cores; ++t) {
      const std::size_t first = bytes * t / cores, end = bytes * (t + 1) / cores;
      threads.emplace_back(
          [&, first, end] { std::memcpy(to.data() + first, from.data() + first, end - first); });
    }
    for (std::thread& thread : threads) thread.join();
    best = std::max(best, 2.0 * static_cast<double>(bytes) / watch.seconds());
  }
  return best;
}

Json record_header(const std::string& subject, const std::string& device) {
  struct sysinfo info {};
  const bool known = sysinfo(&info) == 0;
  return {
      {"format", "kappamu-bench-" + subject},
      {"version", record_version},
      {"program",
       {{"kappamu", KAPPAMU_VERSION}, {"compiler", KAPPAMU_COMPILER}, {"build", KAPPAMU_BUILD}}},
      {"machine",
       {{"cpu", cpu_model()},
        {"cores", usable_cores()},
        {"memory_bytes", known ? static_cast<std::size_t>(info.totalram) * info.mem_unit : 0},
        {"load", machine_load()},
        {"copy_bandwidth_bytes_per_second", host_copy_bandwidth()}}},
      {"device", device}};
}

void write_record(const Json& record, const std::filesystem::path& file) {
  io::write_text_atomically(file, record.dump(1) + "\n");
}

Json read_record(const std::filesystem::path& file, const std::string& subject) {
  std::ifstream in(file);
  if (!in) throw InputError(file.string() + " cannot be read; run the measurement first.");
  Json record = Json::parse(in, nullptr, false);
  if (record.is_discarded() || !record.is_object() ||
      record.value("format", "") != "kappamu-bench-" + subject ||
      record.value("version", 0) != record_version) {
    throw InputError(file.string() + " is no kappamu-bench-" + subject + " record of version " +
                     std::to_string(record_version) + "; remove it and measure again.");
  }
  return record;
}

double median(std::vector<double> values) {
  check(!values.empty(), "median: at least one value");
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

}  // namespace kappamu::studies
