// One stack of a session: load, look for frames that do not fit, merge. Declared in merge.h.
#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <set>
#include <type_traits>

#include "capture/radiance/align.h"
#include "capture/radiance/demosaic.h"
#include "capture/radiance/merge.h"
#include "capture/radiance/steadiness.h"
#include "capture/session/bayer.h"
#include "capture/session/frames.h"
#include "capture/session/frames_at_once.h"
#include "core/error.h"
#include "core/parallel.h"

namespace kappamu::capture {
namespace {

/// Of the picture, not of its light: such frames can be left out.
bool is_motion(const Fault& fault) {
  return fault.kind == Fault::Kind::moved || fault.kind == Fault::Kind::changed ||
         fault.kind == Fault::Kind::blank;
}

struct Advice {
  std::string sentence;
  std::vector<OptionKey> options;
};

Advice advice(const Fault& fault) {
  if (fault.kind == Fault::Kind::blank) {
    return {"photograph it again, or leave the frame out", {{"on_motion", "correct"}}};
  }
  if (is_motion(fault)) {
    return {
        "photograph the stack again, leave the frame out, or, where camera and sample need not "
        "stay fixed, move it back",
        {{"on_motion", "correct"}, {"on_motion", "align"}}};
  }
  if (fault.kind == Fault::Kind::mislabelled) {
    return {
        "correct exposure_s in session.json or in the photographs' table, or let it be estimated",
        {{"on_flicker", "correct"}}};
  }
  return {
      "let lamp and projector warm up and expose multiples of the projector's period, or "
      "estimate the exposures from the frames",
      {{"on_flicker", "correct"}}};
}

// Frames, exposure times and file names of a stack, whatever a frame holds.
template <class Value>
class StackMerger {
 public:
  StackMerger(const Session& session, const Stack& stack, const std::string& label,
              std::vector<Exposed<Value>> frames)
      : session_(session), label_(label), frames_(std::move(frames)) {
    for (const Frame& frame : stack) files_.push_back(frame.file);
  }

  // `pitch` is the distance of neighbouring pixels of the frames in pixels of the picture.
  std::vector<Fault> faults(const Radiometry& radiometry, double pitch) {
    steadiness_ = compare_frames(std::span<const Exposed<Value>>(frames_), radiometry);
    for (std::optional<FrameState>& state : steadiness_) {
      if (!state) continue;
      for (double& shift : state->shift_px) shift *= pitch;
      state->shift_sigma_px *= pitch;
    }
    return find_faults(steadiness_, exposures(), files_, tolerance_for(radiometry));
  }

  // A copy of a photograph is no second measurement, and would halve the variance all the same.
  void refuse_copies() const {
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const auto& values = frames_[i].pixels.values();
      const bool blank =
          std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end();
      for (std::size_t j = 0; j < i && !blank; ++j) {
        if (frames_[i].exposure_s != frames_[j].exposure_s) continue;
        if (values != frames_[j].pixels.values()) continue;
        throw InputError(path(i) + ": is a copy of " + files_[j] + " in every pixel (" + label_ +
                         "); a copy adds no measurement: leave one of the two out.");
      }
    }
  }

  void settle_faults(const Radiometry& radiometry, const MergeOptions& options, double pitch,
                     std::vector<std::string>* notes) {
    if (options.on_flicker == OnFault::ignore && options.on_motion == OnFault::ignore) return;
    if (options.on_motion == OnFault::align) align(radiometry, pitch, notes);
    bool flickers = false;
    std::set<std::size_t> left_out;
    for (const Fault& fault : faults(radiometry, pitch)) {
      const OnFault action = is_motion(fault) ? options.on_motion : options.on_flicker;
      const std::string what = path(fault.frame) + ": " + fault.sentence + " (" + label_ + ")";
      if (action == OnFault::ignore) continue;
      if (action == OnFault::refuse || action == OnFault::align) {
        const Advice fix = advice(fault);
        throw InputError(what + "; " + fix.sentence, fix.options);
      }
      if (is_motion(fault)) {
        left_out.insert(fault.frame);
      } else {
        flickers = true;
      }
      if (notes != nullptr) {
        notes->push_back(what + (is_motion(fault) ? "; the frame is left out."
                                                  : "; its exposure is taken from the frames."));
      }
    }
    // With two frames nobody can say which of them is wrong.
    if (2 * left_out.size() >= frames_.size() && !left_out.empty()) {
      throw InputError(shown_session(session_) + ": " + label_ + ": " +
                       std::to_string(left_out.size()) + " of its " +
                       std::to_string(frames_.size()) +
                       " frames show a scene that moved, too many to leave out; photograph the "
                       "stack again.");
    }
    if (flickers) {
      const std::vector<double> steady = steady_exposures(steadiness_, exposures());
      for (std::size_t i = 0; i < frames_.size(); ++i) frames_[i].exposure_s = steady[i];
    }
    for (auto i = left_out.rbegin(); i != left_out.rend(); ++i) {
      frames_.erase(frames_.begin() + static_cast<std::ptrdiff_t>(*i));
    }
  }

  /// Of the frames moved back, in pixels of the picture.
  const std::vector<std::array<double, 2>>& shifts() const { return shifts_; }

  const std::vector<Exposed<Value>>& frames() const { return frames_; }
  std::string name() const { return shown_session(session_) + ": " + label_; }

 private:
  // Moves shifted frames back onto the middle of their stack.
  void align(const Radiometry& radiometry, double pitch, std::vector<std::string>* notes) {
    for (const Fault& fault : faults(radiometry, pitch)) {
      if (fault.kind != Fault::Kind::moved) continue;
      const std::array<double, 2> shift = steadiness_[fault.frame]->shift_px;
      const std::array<double, 2> of_frame{shift[0] / pitch, shift[1] / pitch};
      if constexpr (std::is_same_v<Value, float>) {
        constexpr float saturated_from = 0.99F;  // as FloatReader
        move_back(of_frame, saturated_from, frames_[fault.frame]);
      } else {
        int saturated_from = saturation_code(radiometry.response.linear.front());
        for (const std::vector<double>& linear : radiometry.response.linear)
          saturated_from = std::min(saturated_from, saturation_code(linear));
        move_back(of_frame, saturated_from, frames_[fault.frame]);
      }
      shifts_.push_back(shift);
      if (notes != nullptr)
        notes->push_back(path(fault.frame) + ": " + fault.sentence + " (" + label_ +
                         "); the frame is moved back.");
    }
  }

  std::vector<double> exposures() const {
    std::vector<double> times;
    for (const Exposed<Value>& frame : frames_) times.push_back(frame.exposure_s);
    return times;
  }
  std::string path(std::size_t frame) const { return (session_.folder / files_[frame]).string(); }

  const Session& session_;
  const std::string& label_;
  std::vector<Exposed<Value>> frames_;
  std::vector<std::string> files_;
  Steadiness steadiness_;
  std::vector<std::array<double, 2>> shifts_;
};

template <class Load>
auto load_all(const Stack& stack, const Load& load) {
  std::vector<std::invoke_result_t<Load, const Frame&>> frames(stack.size());
  for_rows(
      static_cast<int>(stack.size()),
      [&](int j) {
        const auto at = static_cast<std::size_t>(j);
        frames[at] = load(stack[at]);
      },
      frames_at_once);
  return frames;
}

// Calls act(frames, radiometry of their channels, distance of their neighbouring pixels in pixels
// of the picture, what makes the picture of their merge).
template <class Act>
auto with_frames(const Session& session, const Stack& stack, const Radiometry& radiometry,
                 const Part& part, const Act& act) {
  const auto unchanged = [](HdrImage image) { return image; };
  const auto is_float = [&](const Frame& frame) { return is_float_frame(session, frame); };
  if (!stack.empty() && std::all_of(stack.begin(), stack.end(), is_float)) {
    const auto load = [&](const Frame& frame) {
      return ExposedFloatFrame{load_float_frame(session, frame, part), frame.exposure_s};
    };
    return act(load_all(stack, load), radiometry, 1.0, unchanged);
  }
  const auto is_raw = [&](const Frame& frame) { return is_raw_frame(session, frame); };
  if (stack.empty() || !std::all_of(stack.begin(), stack.end(), is_raw)) {
    const auto load = [&](const Frame& frame) {
      return ExposedFrame{load_frame(session, frame, part), frame.exposure_s};
    };
    return act(load_all(stack, load), radiometry, 1.0, unchanged);
  }
  // In the Bayer domain: each site's own codes are merged, their radiance is demosaiced.
  struct Sites {
    Image<std::uint16_t> codes;
    std::optional<io::BayerLayout> layout;
  };
  std::vector<Sites> loaded = load_all(stack, [&](const Frame& frame) {
    io::RawImage raw = load_raw_frame(session, frame, part);
    return Sites{raw.layout ? pack_sites(raw.codes) : std::move(raw.codes), raw.layout};
  });
  const std::optional<io::BayerLayout> layout = loaded.front().layout;
  std::vector<ExposedFrame> frames;
  for (std::size_t j = 0; j < stack.size(); ++j) {
    if (loaded[j].layout != layout) {
      throw InputError((session.folder / stack[j].file).string() +
                       ": its Bayer pattern begins with another colour than that of " +
                       stack.front().file + "; use frames of one camera in one mode.");
    }
    frames.push_back({std::move(loaded[j].codes), stack[j].exposure_s});
  }
  if (!layout) return act(std::move(frames), radiometry, 1.0, unchanged);
  return act(std::move(frames), site_radiometry(radiometry, *layout), 2.0,
             [layout](const HdrImage& packed) { return demosaic(packed, *layout); });
}

}  // namespace

std::vector<Fault> find_stack_faults(const Session& session, const Stack& stack,
                                     const Radiometry& radiometry) {
  const std::string label;
  return with_frames(
      session, stack, radiometry, {},
      [&](auto frames, const Radiometry& of_frames, double pitch, const auto&) {
        return StackMerger(session, stack, label, std::move(frames)).faults(of_frames, pitch);
      });
}

HdrImage merge_stack(const Session& session, const Stack& stack, const std::string& label,
                     const Radiometry& radiometry, const MergeOptions& options,
                     std::vector<std::string>* notes) {
  return with_frames(
      session, stack, radiometry, options.part,
      [&](auto frames, const Radiometry& of_frames, double pitch, const auto& picture) {
        StackMerger merger(session, stack, label, std::move(frames));
        merger.refuse_copies();
        merger.settle_faults(of_frames, options, pitch, notes);
        HdrImage image = picture(merge_frames(merger.frames(), of_frames, merger.name(), options));
        for (const std::array<double, 2>& shift : merger.shifts()) flag_unseen(shift, image);
        if (options.part) {
          image.left = options.part->left;
          image.top = options.part->top;
        }
        return image;
      });
}

}  // namespace kappamu::capture
