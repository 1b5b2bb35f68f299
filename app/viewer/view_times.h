// What a viewing costs: medians over answers and frames, and when the first of each was there.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/viewer/viewer.h"
#include "core/numbers/median.h"

namespace kappamu::app {

class ViewTimes {
 public:
  /// `started` with the command.
  explicit ViewTimes(const Stopwatch& started) : started_(started) {}

  void answered(const render::LiveAnswer& answer) {
    if (times_.answers++ == 0) times_.first_light_s = started_.seconds();
    light_ms_.push_back(answer.light_ms);
    model_ms_.push_back(answer.model_ms);
    if (answer.mode != "static") shape_ms_[answer.mode].push_back(answer.total_ms());
  }
  /// Nothing is left to refine.
  void settled() {
    if (times_.answers > 0 && times_.settled_s == 0.0) times_.settled_s = started_.seconds();
  }
  /// What follows may ask something.
  void begin_event() {
    if (asked_) return;
    event_ = {};
    processor_at_event_ = processor_seconds();
  }
  void asked() { asked_ = true; }
  /// `answered`: the frame shows what was asked last.
  void drawn(double milliseconds, bool answered) {
    if (times_.frames++ == 0) times_.first_picture_s = started_.seconds();
    frame_ms_.push_back(milliseconds);
    if (!asked_ || !answered) return;
    event_ms_.push_back(event_.milliseconds());
    event_processor_ms_.push_back(1e3 * (processor_seconds() - processor_at_event_));
    asked_ = false;
  }
  double last_frame_ms() const { return frame_ms_.empty() ? 0.0 : frame_ms_.back(); }

  ViewerTimes result() const {
    const auto median = [](const std::vector<double>& values) {
      return values.empty() ? 0.0 : upper_median(values);
    };
    ViewerTimes times = times_;
    times.light_ms = median(light_ms_);
    times.model_ms = median(model_ms_);
    times.frame_ms = median(frame_ms_);
    times.event_ms = median(event_ms_);
    times.event_processor_ms = median(event_processor_ms_);
    for (const auto& [mode, milliseconds] : shape_ms_) times.shape_ms[mode] = median(milliseconds);
    return times;
  }

 private:
  Stopwatch started_;
  ViewerTimes times_;
  std::vector<double> light_ms_, model_ms_, frame_ms_, event_ms_, event_processor_ms_;
  Stopwatch event_;
  double processor_at_event_ = 0.0;
  bool asked_ = false;                                   ///< by the event, and not shown yet
  std::map<std::string, std::vector<double>> shape_ms_;  ///< answers to shapes that moved, by mode
};

}  // namespace kappamu::app
