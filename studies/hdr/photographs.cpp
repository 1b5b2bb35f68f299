// Time and memory of the steps from photographs to measurements, by `kappamu` itself, beside the
// time that decoding the same files takes: the floor of each.
#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/session/frames.h"
#include "capture/session/session_files.h"
#include "core/error.h"
#include "core/file_name.h"
#include "core/parallel.h"
#include "core/processor_time.h"
#include "studies/subjects.h"

namespace kappamu::studies {

namespace {

namespace fs = std::filesystem;

struct Cost {
  double wall_s = 0.0, processor_s = 0.0, peak_gb = 0.0;
};

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// Of the program `kappamu` beside this one, whose output goes to `log`.
Cost cost_of(std::vector<std::string> words, const fs::path& log) {
  words.insert(words.begin(), (fs::read_symlink("/proc/self/exe").parent_path() / "kappamu"));
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                   0644);
  posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  const Stopwatch watch;
  pid_t child = 0;
  const int failed = posix_spawn(&child, arguments[0], &files, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  int status = 0;
  rusage usage{};
  if (failed == 0) wait4(child, &status, 0, &usage);
  if (failed != 0 || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw InputError("`kappamu " + words.at(1) + "` failed; " + log.string() + " says why");
  }
  return {watch.seconds(), seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime),
          1024e-9 * static_cast<double>(usage.ru_maxrss)};
}

Cost decoding(const capture::Session& session, const std::vector<capture::Frame>& frames) {
  const Stopwatch watch;
  const double before = processor_seconds();
  for_rows(static_cast<int>(frames.size()), [&](int k) {
    capture::load_rows(session, frames[static_cast<std::size_t>(k)],
                       [](int, const std::uint16_t*) {});
  });
  return {watch.seconds(), processor_seconds() - before, 0.0};
}

/// The camera's photographs that session.json names: those of patterns, or all others.
std::vector<capture::Frame> photographs(const capture::Session& session, bool of_patterns) {
  std::vector<capture::Frame> patterns, others;
  std::vector<std::string> taken;
  for (const capture::Pattern& pattern : session.patterns) {
    patterns.insert(patterns.end(), pattern.frames.begin(), pattern.frames.end());
    taken.push_back(pattern.image);
  }
  for (const capture::Frame& frame : patterns) taken.push_back(frame.file);
  for (const std::string& file : capture::named_files(session)) {
    const std::string ending = lower_extension(file);
    const bool data =
        ending == ".npy" || ending == ".yml" || ending == ".yaml" || ending == ".json";
    if (!data && std::find(taken.begin(), taken.end(), file) == taken.end())
      others.push_back({file, 1.0});
  }
  return of_patterns ? patterns : others;
}

void measure_photographs(const Request& request, Progress& progress, const Save& save) {
  const std::string size = request.size == Size::quick   ? "400x300"
                           : request.size == Size::small ? "3000x2000"
                                                         : "6000x4000";
  const fs::path work = request.folder / ("photographs-" + size);
  Json rows = Json::array();
  fs::path folder = work / "session";
  const auto add = [&](const std::string& step, std::size_t count, double megabytes,
                       const Cost& cost, double floor_s) {
    Json row{{"step", step},
             {"files", count},
             {"MB", megabytes},
             {"wall s", cost.wall_s},
             {"processor s", cost.processor_s},
             {"peak GB", cost.peak_gb}};
    row["of decoding"] = floor_s > 0.0 ? cost.processor_s / floor_s : 1.0;
    rows.push_back(row);
    save({{"session", folder.string()}, {"rows", rows}});
  };
  const auto step = [&](const char* name) { progress.update("photographs", 0.0, name); };
  if (!request.has("session")) fs::remove_all(work);
  fs::create_directories(work);  // for the logs
  if (request.has("session")) {
    folder = request.words("session").at(0);
  } else {
    step("simulate");
    const Cost cost = cost_of({"simulate", "--sample", "tiny", "--camera", size, "--boards", "6",
                               "--planes", "4", "--bars", "4", "--exposures", "0.033", "0.5", "8",
                               "--holdout", "0", "-o", (work / "rig").string()},
                              work / "simulate.log");
    folder = work / "rig" / "session";
    add("simulate", 0, 0.0, cost, 0.0);
  }
  const capture::Session session = capture::read_session(folder);
  std::array<double, 2> floors{};
  std::array<std::size_t, 2> counts{};
  std::array<double, 2> sizes{};
  for (const bool of_patterns : {false, true}) {
    const std::vector<capture::Frame> frames = photographs(session, of_patterns);
    for (const capture::Frame& frame : frames)
      sizes[of_patterns] += 1e-6 * static_cast<double>(fs::file_size(session.folder / frame.file));
    step("decode");
    const Cost cost = decoding(session, frames);
    counts[of_patterns] = frames.size();
    floors[of_patterns] = cost.processor_s;
    add(of_patterns ? "decode, patterns" : "decode, others", frames.size(), sizes[of_patterns],
        cost, cost.wall_s);
  }
  const fs::path run = work / "run";
  fs::remove_all(run);
  for (const char* name : {"calibrate", "merge", "report"}) {
    step(name);
    std::vector<std::string> words{name};
    if (name != std::string("report")) words.insert(words.end(), {folder.string(), "-o"});
    words.push_back(run.string());
    const bool merges = name == std::string("merge");
    const Cost cost = cost_of(words, work / (std::string(name) + ".log"));
    add(name, counts[merges], sizes[merges], cost, floors[merges]);
  }
}

}  // namespace

Subject photographs_subject() {
  return {"photographs",
          "Time and memory from photographs to measurements, beside their decoding (docs/hdr.md)",
          R"(  kappamu-studies photographs -o out/

Simulates a session of 24 megapixels (--small: 6), or takes the one of --session, decodes its
photographs, then calibrates, merges and reports. Each step is a process of its own, whose largest
memory is told. Files have just been read or written: the disk's time is not in the figures where
memory holds them.)",
          {{"photographs", "decode, calibrate, merge, report", measure_photographs}},
          {{"session", "Folder of a session to take instead", Setting::Kind::words}}};
}

}  // namespace kappamu::studies
