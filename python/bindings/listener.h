// Long work for Python: in a thread of its own, without the interpreter's lock, while the caller's
// thread passes on progress and warnings and hears Ctrl-C.
#pragma once

#include <pybind11/pybind11.h>

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "core/progress.h"

namespace kappamu::python {

namespace py = pybind11;

/// What a working thread says, until the caller's thread passes it on.
class Mail {
 public:
  struct Letter {
    bool warning = false;
    std::string text;  ///< stage, or the warning's sentence
    double fraction = 0.0;
    std::string detail;
  };

  /// Of the working threads; throws Cancelled once cancel() was called.
  void update(const std::string& stage, double fraction, const std::string& detail);
  void warn(const std::string& sentence);
  /// The work is over.
  void close();
  void cancel();

  /// Waits for letters, at most a moment; whether the work goes on.
  bool collect(std::deque<Letter>& letters);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Letter> letters_;
  bool closed_ = false;
  bool cancelled_ = false;
};

/// The Progress that writes to a Mail, as the libraries take it.
class MailProgress : public Progress {
 public:
  explicit MailProgress(std::shared_ptr<Mail> mail) : mail_(std::move(mail)) {}
  void update(const std::string& stage, double fraction, const std::string& detail) override {
    mail_->update(stage, fraction, detail);
  }
  void warn(const std::string& sentence) override { mail_->warn(sentence); }

 private:
  std::shared_ptr<Mail> mail_;
};

/// Does `work` in another thread, rethrows what it throws, and meanwhile calls progress(stage,
/// fraction, detail) in this one unless it is None; warnings become Python's. Ctrl-C and exceptions
/// of `progress` cancel the work at its next update.
void listen(const py::object& progress, const std::function<void(std::shared_ptr<Mail>)>& work);

}  // namespace kappamu::python
