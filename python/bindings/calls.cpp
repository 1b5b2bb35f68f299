#include "python/bindings/calls.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace kappamu::python {

namespace {

// Under the interpreter's lock.
std::vector<const Call*> calls;
bool ending = false;
const pid_t process = getpid();

}  // namespace

Call::Call(std::function<void()> cancel) : cancel_(std::move(cancel)) {
  if (ending) throw std::runtime_error("kappamu takes no calls while the interpreter ends");
  calls.push_back(this);
}

Call::~Call() {
  calls.erase(std::find(calls.begin(), calls.end(), this));
}

void end_calls() {
  constexpr std::chrono::milliseconds moment(10);
  if (getpid() != process) return;  // threads of the process that was forked are not here
  ending = true;
  for (const Call* call : calls) {
    if (call->cancel_) call->cancel_();
  }
  while (!calls.empty()) {
    const py::gil_scoped_release release;
    std::this_thread::sleep_for(moment);
  }
}

}  // namespace kappamu::python
