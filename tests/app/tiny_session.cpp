#include "tests/app/tiny_session.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <stdexcept>

#include "io/atomic_file.h"
#include "io/read_file.h"

namespace kappamu {

namespace {

namespace fs = std::filesystem;

/// What `kappamu arguments -o FOLDER` writes, in a folder of all tests.
fs::path made(const std::string& name, const std::string& arguments) {
  const fs::path folder = fs::path(KAPPAMU_TEST_FOLDER) / "tiny";
  fs::create_directories(folder);
  // CTest runs tests in processes of their own, several at once: the first makes it.
  const int lock = open((folder / (name + ".lock")).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  flock(lock, LOCK_EX);
  const fs::path complete = folder / (name + ".complete");
  // What is older than the program may be of another format.
  const bool is_current =
      fs::exists(complete) && fs::last_write_time(complete) > fs::last_write_time(KAPPAMU_PROGRAM);
  if (!is_current) {
    fs::remove_all(folder / name);
    const ProcessResult result = kappamu(arguments + " -o " + (folder / name).string());
    if (result.exit_code != 0 && result.exit_code != 3) {
      close(lock);
      throw std::runtime_error("kappamu " + arguments + " failed: " + result.standard_error);
    }
    io::write_text_atomically(complete,
                              std::to_string(result.exit_code) + "\n" + result.standard_output);
  }
  close(lock);
  return folder / name;
}

}  // namespace

const fs::path& tiny_session() {
  static const fs::path session =
      made("capture", "simulate --sample tiny --seed 3 --patches 2 --holdout 0") / "session";
  return session;
}

const fs::path& tiny_run() {
  static const fs::path run = made("run", tiny_run_arguments());
  return run;
}

std::string tiny_run_arguments() {
  return "run " + tiny_session().string() + " --device reference --json";
}

ProcessResult tiny_run_result() {
  const std::string text = io::read_text(tiny_run().string() + ".complete");
  const std::size_t end = text.find('\n');
  return {std::stoi(text.substr(0, end)), text.substr(end + 1), {}};
}

fs::path copied_run(const fs::path& folder) {
  fs::copy(tiny_run(), folder, fs::copy_options::recursive);
  return folder;
}

fs::path linked_session(const fs::path& folder) {
  fs::copy(tiny_session(), folder,
           fs::copy_options::recursive | fs::copy_options::create_hard_links);
  return folder;
}

}  // namespace kappamu
