#include "app/viewer/answers.h"

#include <chrono>

#include "core/error.h"

namespace kappamu::app {

namespace {

/// An answer of this time is waited for, though another question is asked: a hand that keeps moving
/// shall see where it is [s].
constexpr double worth_waiting_s = 0.5;
/// A hand that moves asks again within this time after an answer [s]: nothing is begun that it
/// would interrupt.
constexpr double pause_s = 0.15;

}  // namespace

class Answers::Listener : public Progress {
 public:
  explicit Listener(Answers& answers) : answers_(answers) {}
  void update(const std::string& stage, double fraction, const std::string& detail) override {
    const std::lock_guard lock(answers_.mutex_);
    if (answers_.cancelled()) throw Cancelled();
    answers_.now_.stage = stage;
    answers_.now_.detail = detail;
    answers_.now_.fraction = fraction;
  }

 private:
  Answers& answers_;
};

Answers::Answers(render::LiveScene& scene, std::function<void()> ready)
    : scene_(scene), ready_(std::move(ready)), thread_([this] { work(); }) {}

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
    picture_.reset();
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
  return asked_ || (working_ && !now_.refining) || answer_ || failure_;
}

bool Answers::refining() const {
  const std::lock_guard lock(mutex_);
  return refining_ || (working_ && now_.refining);
}

void Answers::look(const std::optional<render::PictureView>& view) {
  {
    const std::lock_guard lock(mutex_);
    if (view == view_) return;
    view_ = view;
    picture_.reset();
    traced_all_ = false;
  }
  changed_.notify_all();
}

std::optional<Answers::Traced> Answers::take_picture() {
  const std::lock_guard lock(mutex_);
  return std::exchange(picture_, std::nullopt);
}

bool Answers::tracing() const {
  const std::lock_guard lock(mutex_);
  return may_trace() || picture_;
}

std::optional<Answers::Work> Answers::work_now() const {
  const std::lock_guard lock(mutex_);
  if (!working_) return std::nullopt;
  Work now = now_;
  now.seconds = since_.seconds();
  return now;
}

/// With the mutex held.
bool Answers::cancelled() const {
  if (now_.tracing && view_ != traced_view_) return true;
  return stop_ || (asked_ && (now_.refining || since_.seconds() > worth_waiting_s));
}

void Answers::work() {
  Listener progress(*this);
  std::unique_lock lock(mutex_);
  Stopwatch since_answer;
  while (!stop_) {
    if (!asked_ && !refining_ && !may_trace()) {
      changed_.wait(lock);
      continue;
    }
    const double pause = pause_s - since_answer.seconds();
    if (!asked_ && pause > 0.0) {
      changed_.wait_for(lock, std::chrono::duration<double>(pause));
      continue;
    }
    const std::optional<render::LiveQuestion> question = std::exchange(asked_, std::nullopt);
    working_ = true;
    now_ = {};
    now_.refining = !question;
    now_.tracing = !question && !refining_;
    if (now_.tracing) traced_view_ = *view_;
    since_ = {};
    lock.unlock();
    std::optional<render::LiveAnswer> answer;
    std::optional<render::Picture> picture;
    std::exception_ptr failure;
    bool given_up = false;
    try {
      if (now_.tracing) {
        picture = scene_.traced(traced_view_, progress);
      } else {
        answer = question ? scene_.answer(*question, progress) : scene_.refined(progress);
      }
    } catch (const Cancelled&) {
      given_up = true;
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    working_ = false;
    if (question) since_answer = {};
    failure_ = failure;
    if (now_.tracing) {
      const bool wanted = !asked_ && view_ == traced_view_;
      if (wanted && !given_up) traced_all_ = !picture;
      if (wanted && picture) picture_ = {std::move(*picture), traced_view_};
    } else {
      refining_ = answer || given_up;
    }
    if (answer) {
      answered_ = true;
      traced_all_ = false;
      if (answer_) answer->take_over(*answer_);
      answer_ = std::move(answer);
    }
    lock.unlock();
    ready_();
    lock.lock();
    if (failure_) return;
  }
}

}  // namespace kappamu::app
