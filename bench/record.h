// The raw record of a measurement: what ran, where, and every number behind a chart, as JSON.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace kappamu::bench {

struct Machine {
  std::string cpu;               ///< model name as the kernel gives it
  int cores = 0;                 ///< that this process may run on
  std::size_t memory_bytes = 0;  ///< of the host
  double load = 0.0;             ///< processes that ran or waited to, mean of the last minute
};
Machine this_machine();

/// Bytes read plus bytes written per second by a plain copy of 128 MiB, all cores together, best of
/// `repetitions` [bytes/s]: what no kernel that streams its data can beat.
double host_copy_bandwidth(int repetitions = 7);

/// "format" ("kappamu-bench-<subject>"), "version", "program" (version, compiler, build type),
/// "machine" (cpu, cores, memory, load, copy bandwidth) and "device": the beginning of every
/// record.
nlohmann::ordered_json record_header(const std::string& subject, const std::string& device);

void write_record(const nlohmann::ordered_json& record, const std::filesystem::path& file);

/// Throws InputError naming the file unless it holds a record of this subject and version.
nlohmann::ordered_json read_record(const std::filesystem::path& file, const std::string& subject);

/// The middle value, or the mean of the two middle ones; of at least one value.
double median(std::vector<double> values);

}  // namespace kappamu::bench
