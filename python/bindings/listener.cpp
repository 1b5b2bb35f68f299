#include "python/bindings/listener.h"

#include <chrono>
#include <exception>
#include <optional>
#include <thread>
#include <utility>

#include "core/error.h"
#include "core/process_memory.h"
#include "python/bindings/calls.h"

namespace kappamu::python {

void Mail::update(const std::string& stage, double fraction, const std::string& detail) {
  const std::scoped_lock lock(mutex_);
  if (cancelled_) throw Cancelled();
  // Only the last of a stage is of interest.
  if (!letters_.empty() && !letters_.back().warning && letters_.back().text == stage)
    letters_.pop_back();
  letters_.push_back({false, stage, fraction, detail});
}

void Mail::warn(const std::string& sentence) {
  const std::scoped_lock lock(mutex_);
  letters_.push_back({true, sentence, 0.0, {}});
}

void Mail::close() {
  {
    const std::scoped_lock lock(mutex_);
    closed_ = true;
  }
  changed_.notify_one();
}

void Mail::cancel() {
  const std::scoped_lock lock(mutex_);
  cancelled_ = true;
}

bool Mail::collect(std::deque<Letter>& letters) {
  constexpr std::chrono::milliseconds moment(50);
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, moment, [this] { return closed_; });
  letters = std::exchange(letters_, {});
  return !closed_;
}

namespace {

void pass_on(const std::deque<Mail::Letter>& letters, const py::object& progress) {
  for (const Mail::Letter& letter : letters) {
    if (letter.warning) {
      py::module_::import("kappamu.errors").attr("warn")(letter.text);
    } else if (!progress.is_none()) {
      progress(letter.text, letter.fraction, letter.detail);
    }
  }
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

/// While a call works, freed memory is kept for it as the program keeps it; then the interpreter
/// has its usual rule again. Calls of several threads overlap.
class KeptMemory {
 public:
  KeptMemory() {
    if (calls_++ == 0) keep_freed_memory();
  }
  ~KeptMemory() {
    if (--calls_ == 0) return_freed_memory();
  }
  KeptMemory(const KeptMemory&) = delete;
  KeptMemory& operator=(const KeptMemory&) = delete;

 private:
  static inline int calls_ = 0;  // under the interpreter's lock
};

}  // namespace

void listen(const py::object& progress, const std::function<void(std::shared_ptr<Mail>)>& work) {
  const auto mail = std::make_shared<Mail>();
  std::exception_ptr failure;
  std::optional<py::error_already_set> interruption;
  const Call call([mail] { mail->cancel(); });
  const KeptMemory memory;
  std::thread thread([&] {
    try {
      work(mail);
    } catch (...) {
      failure = std::current_exception();
    }
    mail->close();
  });
  for (bool working = true; working;) {
    std::deque<Mail::Letter> letters;
    {
      const py::gil_scoped_release release;
      working = mail->collect(letters);
    }
    if (interruption) continue;
    try {
      pass_on(letters, progress);
    } catch (py::error_already_set& error) {
      interruption.emplace(std::move(error));
      mail->cancel();
    }
  }
  thread.join();
  if (interruption) throw std::move(*interruption);
  if (failure) std::rethrow_exception(failure);
}

}  // namespace kappamu::python
