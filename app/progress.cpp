// What a command says while it works and at its end: to a terminal, or to the program that called.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "core/shown_text.h"

namespace kappamu::app {

namespace {

class TerminalProgress : public Progress {
 public:
  explicit TerminalProgress(bool is_terminal) : is_terminal_(is_terminal) {}
  ~TerminalProgress() override { finish_line(); }
  TerminalProgress(const TerminalProgress&) = delete;
  TerminalProgress& operator=(const TerminalProgress&) = delete;

  void update(const std::string& stage, double fraction, const std::string& detail) override {
    if (!is_terminal_) return;
    const auto now = std::chrono::steady_clock::now();
    const bool is_new = stage != stage_;
    if (!is_new && fraction < 1.0 && now - last_ < std::chrono::milliseconds(100)) return;
    if (is_new) finish_line();
    stage_ = stage;
    last_ = now;
    constexpr int width = 30;
    const int filled = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * width);
    std::fprintf(stderr, "\r\033[K%-16s [%s%s] %3.0f%% %s", stage.c_str(),
                 std::string(filled, '#').c_str(), std::string(width - filled, '.').c_str(),
                 100.0 * fraction, shown_text(detail).c_str());
    std::fflush(stderr);
    line_open_ = true;
    if (fraction >= 1.0) finish_line();
  }

  void warn(const std::string& sentence) override {
    finish_line();
    std::fprintf(stderr, "warning: %s\n", shown_text(sentence).c_str());
  }

 private:
  void finish_line() {
    if (line_open_) std::fprintf(stderr, "\n");
    line_open_ = false;
    stage_.clear();
  }

  bool is_terminal_;
  bool line_open_ = false;
  std::string stage_;
  std::chrono::steady_clock::time_point last_;
};

thread_local Caller* caller_of_thread = nullptr;

}  // namespace

CalledBy::CalledBy(Caller& caller) {
  caller_of_thread = &caller;
}
CalledBy::~CalledBy() {
  caller_of_thread = nullptr;
}

void print_json(const nlohmann::ordered_json& object) {
  if (caller_of_thread != nullptr) return caller_of_thread->result(object);
  std::printf("%s\n",
              object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
}

std::unique_ptr<Progress> make_progress() {
  if (caller_of_thread != nullptr) return caller_of_thread->progress();
  return std::make_unique<TerminalProgress>(isatty(STDERR_FILENO) == 1);
}

}  // namespace kappamu::app
