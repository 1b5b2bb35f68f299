// Checks of single fields of a session that its whole check and that of its calibration share.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "capture/session/frames.h"
#include "capture/session/session.h"
#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"

namespace kappamu::capture {

/// Throws InputError where session.calibration does not fulfil docs/formats.md; the rest of the
/// session is checked already.
void check_calibration(const Session& session);

/// Each throws InputError with the session's file (frames.h), the field and what is wrong with it.
class FieldCheck {
 protected:
  explicit FieldCheck(const Session& session) : session_(session), file_(shown_session(session)) {}

  [[noreturn]] void fail(const std::string& field, const std::string& what) const {
    throw InputError(file_ + ": " + field + " " + what + ".");
  }
  void require(bool holds, const std::string& field, const std::string& what) const {
    if (!holds) fail(field, what);
  }
  void whole(int value, int low, int high, const std::string& field) const {
    require(value >= low && value <= high, field,
            "is " + std::to_string(value) + "; it must lie between " + std::to_string(low) +
                " and " + std::to_string(high));
  }
  void positive(double value, const std::string& field, const std::string& unit) const {
    require(std::isfinite(value) && value > 0.0, field,
            "is " + shown(value) + "; it must be a positive number" + unit);
  }

  void relative_path(const std::string& path, const std::string& field) const {
    require(!path.empty(), field, "is empty; name a file inside the session folder");
    require(stays_inside(path), field,
            "is '" + shown_name(path) +
                "'; file names are relative to the session folder and stay inside it");
  }

  void frame(const Frame& frame, const std::string& field) const {
    relative_path(frame.file, field + ".file");
    positive(frame.exposure_s, field + ".exposure_s", " of seconds");
  }
  void frames(const std::vector<Frame>& list, const std::string& field) const {
    require(!list.empty(), field, "has no frames; list at least one");
    for (std::size_t i = 0; i < list.size(); ++i) frame(list[i], indexed(field, i));
  }
  // Frames of one unchanging scene. Those of one exposure time are averaged: each has its own file.
  void stack(const Stack& list, const std::string& field) const {
    frames(list, field);
    for (std::size_t i = 0; i < list.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        require(list[i].file != list[j].file, indexed(field, i) + ".file",
                "is the same file as " + indexed(field, j) + " ('" + list[i].file +
                    "'); each exposure has its own file");
      }
    }
  }
  void stack_if_any(const Stack& list, const std::string& field) const {
    if (!list.empty()) stack(list, field);
  }
  static std::string indexed(const std::string& field, std::size_t i) {
    return field + "[" + std::to_string(i) + "]";
  }

  void name(const std::string& text, const std::string& field) const {
    require_plain_name(text, file_ + ": " + field);
  }

  static std::string shown(double value) { return shown_number(value, "%.9g"); }

  const Session& session_;

 private:
  std::string file_;
};

}  // namespace kappamu::capture
