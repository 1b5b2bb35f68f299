#include "tests/app/process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

namespace kappamu {

namespace {

namespace fs = std::filesystem;

std::string contents(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream all;
  all << in.rdbuf();
  return all.str();
}

int exit_code_of(int status) {
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// Starts /bin/sh -c command with its outputs in files.
pid_t start(const std::string& command, const std::string& output, const std::string& error) {
  const pid_t child = fork();
  if (child != 0) return child;
  const int out = open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int err = open(error.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int in = open("/dev/null", O_RDONLY);
  dup2(in, STDIN_FILENO);
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
  _exit(127);
}

}  // namespace

ProcessResult run_process(const std::string& shell_command) {
  const OwnFolder outputs;
  const fs::path out = outputs / "out", error = outputs / "error";
  const pid_t child = start(shell_command, out, error);
  int status = 0;
  waitpid(child, &status, 0);
  return {exit_code_of(status), contents(out), contents(error)};
}

ProcessResult kappamu(const std::string& arguments, const std::string& environment) {
  ProcessResult result = run_process(environment + " " KAPPAMU_PROGRAM " " + arguments);
  const std::size_t line = result.standard_error.find(build_notice);
  if (line != std::string::npos) {
    result.standard_error.erase(line, result.standard_error.find('\n', line) + 1 - line);
  }
  return result;
}

bool kappamu_killed_after(const std::string& arguments, int milliseconds) {
  // exec: the signal must reach kappamu itself, not a shell around it.
  const pid_t child = start("exec " KAPPAMU_PROGRAM " " + arguments, "/dev/null", "/dev/null");
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(milliseconds);
  int status = 0;
  while (std::chrono::steady_clock::now() < end) {
    if (waitpid(child, &status, WNOHANG) == child) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  kill(child, SIGKILL);
  waitpid(child, &status, 0);
  return WIFSIGNALED(status);
}

std::string last_line(const std::string& output) {
  const std::size_t end = output.find_last_not_of('\n');
  if (end == std::string::npos) return {};
  const std::size_t begin = output.rfind('\n', end);
  return output.substr(begin == std::string::npos ? 0 : begin + 1,
                       end - (begin == std::string::npos ? 0 : begin + 1) + 1);
}

void expect_one_sentence(const ProcessResult& result, const std::string& part) {
  EXPECT_EQ(result.exit_code, 1) << result.standard_output << result.standard_error;
  EXPECT_EQ(result.standard_error.rfind("kappamu: ", 0), 0U) << result.standard_error;
  EXPECT_EQ(result.standard_error.find('\n'), result.standard_error.size() - 1)
      << "not one line: " << result.standard_error;
  EXPECT_NE(result.standard_error.find(part), std::string::npos)
      << "no '" << part << "' in: " << result.standard_error;
}

}  // namespace kappamu
