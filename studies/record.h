// The raw record of a measurement: what ran, where, and every number behind a chart, as JSON.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace kappamu::studies {

using Json = nlohmann::ordered_json;

/// Of this process: cores it may run on, and processes that ran or waited to, mean of the last
/// minute.
int usable_cores();
double machine_load();

/// Bytes read plus bytes written per second by a plain copy of 128 MiB, all cores together, best of
/// `repetitions` [bytes/s]: what no kernel that streams its data can beat.
double host_copy_bandwidth(int repetitions = 7);

/// "format" ("kappamu-bench-<subject>"), "version", "program" (version, compiler, build type),
/// "machine" (cpu, cores, memory, load, copy bandwidth) and "device": the beginning of every
/// record.
Json record_header(const std::string& subject, const std::string& device);

void write_record(const Json& record, const std::filesystem::path& file);

/// Throws InputError naming the file unless it holds a record of this subject and version.
Json read_record(const std::filesystem::path& file, const std::string& subject);

/// The middle value, or the mean of the two middle ones; of at least one value.
double median(std::vector<double> values);

}  // namespace kappamu::studies
