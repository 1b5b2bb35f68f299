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

  /// `last`: nothing was asked since.
  void answered(const render::LiveAnswer& answer, bool last) {
    if (times_.answers++ == 0) times_.first_light_s = started_.seconds();
    light_ms_.push_back(answer.light_ms);
    model_ms_.push_back(answer.model_ms);
    if (answer.mode != "static") shape_ms_[answer.mode].push_back(answer.total_ms());
    if (last && asked_) to_draw_ = std::exchange(asked_, std::nullopt);
  }
  /// Nothing is left to refine.
  void settled() {
    if (times_.answers > 0 && times_.settled_s == 0.0) times_.settled_s = started_.seconds();
  }
  /// What follows may ask something.
  void begin_event() { event_ = {}; }
  void asked() {
    if (!asked_) asked_ = event_;
  }
  void drawn(double milliseconds) {
    if (times_.frames++ == 0) times_.first_picture_s = started_.seconds();
    frame_ms_.push_back(milliseconds);
    if (!to_draw_) return;
    event_ms_.push_back(to_draw_->since.milliseconds());
    // The next question may be worked on while a picture is drawn.
    const bool together = last_drawn_ && last_drawn_->since.seconds() < to_draw_->since.seconds();
    const Moment& from = together ? *last_drawn_ : *to_draw_;
    picture_ms_.push_back(from.since.milliseconds());
    picture_processor_ms_.push_back(1e3 * (processor_seconds() - from.processor));
    last_drawn_ = Moment();
    to_draw_.reset();
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
    times.picture_ms = median(picture_ms_);
    times.picture_processor_ms = median(picture_processor_ms_);
    for (const auto& [mode, milliseconds] : shape_ms_) times.shape_ms[mode] = median(milliseconds);
    return times;
  }

 private:
  Stopwatch started_;
  ViewerTimes times_;
  std::vector<double> light_ms_, model_ms_, frame_ms_, event_ms_, picture_ms_,
      picture_processor_ms_;
  struct Moment {
    Stopwatch since;
    double processor = processor_seconds();
  };
  Moment event_;
  std::optional<Moment> asked_;                          ///< by the event, and not answered yet
  std::optional<Moment> to_draw_;                        ///< answered, and not drawn yet
  std::optional<Moment> last_drawn_;                     ///< answer
  std::map<std::string, std::vector<double>> shape_ms_;  ///< answers to shapes that moved, by mode
};

}  // namespace kappamu::app
