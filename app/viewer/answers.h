// The live scene's answers on a thread of their own, so that the window never waits for one: of
// questions asked while it works, the last is answered next; where nothing is asked, the last
// answer is refined until nothing is left to do, and then its picture is traced.
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/processor_time.h"
#include "render/live/live_scene.h"

namespace kappamu::app {

class Answers {
 public:
  /// Keeps a reference to the scene. `ready` is called on the thread where there is an answer to
  /// take, or nothing left to do.
  Answers(render::LiveScene& scene, std::function<void()> ready);
  /// Work that goes on is cancelled.
  ~Answers();

  /// Ends a refinement that goes on, and an answer that takes long.
  void ask(render::LiveQuestion question);
  /// The newest answer not taken yet. Rethrows what ended the work.
  std::optional<render::LiveAnswer> take();
  /// Whether something is asked whose answer has not been taken.
  bool waiting() const;
  /// Whether a better answer may come.
  bool refining() const;

  /// The view whose picture is traced once nothing is left to refine; none: none is. Another view
  /// ends the work on the last one.
  void look(const std::optional<render::PictureView>& view);
  struct Traced {
    render::Picture picture;
    render::PictureView view;
  };
  /// The newest picture, not taken yet, of the last answer.
  std::optional<Traced> take_picture();
  /// Whether a better picture may come.
  bool tracing() const;

  /// What goes on.
  struct Work {
    std::string stage, detail;
    double fraction = 0.0, seconds = 0.0;
    bool refining = false;  ///< the answer shown is of what was asked
    bool tracing = false;   ///< and nothing is left to refine
  };
  std::optional<Work> work_now() const;

 private:
  class Listener;

  void work();
  bool cancelled() const;
  bool may_trace() const { return answered_ && view_ && !traced_all_; }

  render::LiveScene& scene_;
  std::function<void()> ready_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<render::LiveQuestion> asked_;
  std::optional<render::LiveAnswer> answer_;
  std::exception_ptr failure_;
  std::optional<render::PictureView> view_;
  render::PictureView traced_view_;  ///< of the work that goes on
  std::optional<Traced> picture_;
  bool answered_ = false, traced_all_ = false;
  bool working_ = false, refining_ = false, stop_ = false;
  Work now_;
  Stopwatch since_;
  std::thread thread_;
};

}  // namespace kappamu::app
