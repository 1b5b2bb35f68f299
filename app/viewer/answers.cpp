#include "app/viewer/answers.h"

#include <functional>

#include "core/error.h"

namespace kappamu::app {

namespace {

class Stoppable : public Progress {
 public:
  explicit Stoppable(std::function<bool()> stopped) : stopped_(std::move(stopped)) {}
  void update(const std::string&, double, const std::string&) override {
    if (stopped_()) throw Cancelled();
  }

 private:
  std::function<bool()> stopped_;
};

}  // namespace

Answers::Answers(render::LiveScene& scene) : scene_(scene), thread_([this] { work(); }) {}

Answers::~Answers() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Answers::ask(render::LiveQuestion question) {
  {
    const std::lock_guard lock(mutex_);
    asked_ = std::move(question);
  }
  changed_.notify_all();
}

std::optional<render::LiveAnswer> Answers::take() {
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
  return std::exchange(answer_, std::nullopt);
}

bool Answers::waiting() const {
  const std::lock_guard lock(mutex_);
  return asked_ || working_ || answer_;
}

void Answers::work() {
  Stoppable progress([this] {
    const std::lock_guard lock(mutex_);
    return stop_;
  });
  std::unique_lock lock(mutex_);
  while (!stop_) {
    if (!asked_) {
      changed_.wait(lock);
      continue;
    }
    const render::LiveQuestion question = *std::exchange(asked_, std::nullopt);
    working_ = true;
    lock.unlock();
    std::optional<render::LiveAnswer> answer;
    std::exception_ptr failure;
    try {
      answer = scene_.answer(question, progress);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    working_ = false;
    failure_ = failure;
    if (answer && answer_) answer->take_over(*answer_);
    answer_ = std::move(answer);
    if (failure_) return;
  }
}

}  // namespace kappamu::app
