// Calls at work, for which the interpreter waits before it ends: a thread that asks for its lock
// afterwards is ended in the midst of C++, and that ends the process by a signal.
#pragma once

#include <pybind11/pybind11.h>

#include <functional>

namespace kappamu::python {

namespace py = pybind11;

/// One call, from its begin to its end, both under the interpreter's lock.
class Call {
 public:
  /// `cancel` asks the work to stop. Throws once the interpreter is ending.
  explicit Call(std::function<void()> cancel = {});
  ~Call();
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

 private:
  std::function<void()> cancel_;
  friend void end_calls();
};

/// A call that works without the interpreter's lock.
class Released {
  Call call_;  // until the lock is held again
  py::gil_scoped_release release_;
};

/// Cancels all calls and waits for them; none begins afterwards.
void end_calls();

}  // namespace kappamu::python
