// The live scene's answers on a thread of their own, so that the window never waits for one: of
// questions asked while it works, the last is answered next.
#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "render/live/live_scene.h"

namespace kappamu::app {

class Answers {
 public:
  /// Keeps a reference to the scene.
  explicit Answers(render::LiveScene& scene);
  /// Work that goes on is cancelled.
  ~Answers();

  void ask(render::LiveQuestion question);
  /// The newest answer not taken yet. Rethrows what ended the work.
  std::optional<render::LiveAnswer> take();
  /// Whether something is asked whose answer has not been taken.
  bool waiting() const;

 private:
  void work();

  render::LiveScene& scene_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<render::LiveQuestion> asked_;
  std::optional<render::LiveAnswer> answer_;
  std::exception_ptr failure_;
  bool working_ = false, stop_ = false;
  std::thread thread_;
};

}  // namespace kappamu::app
