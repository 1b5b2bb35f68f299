// How long work reports what it is doing, without knowing who listens.
#pragma once

#include <string>

namespace kappamu {

/// Receives progress of long work. The default ignores everything. A listener may throw Cancelled
/// (core/error.h) from update(): the work ends there.
class Progress {
 public:
  virtual ~Progress() = default;
  /// `stage` names the work ("fit R"), `fraction` lies in [0, 1], `detail` is a short line
  /// ("objective 1.2e-3").
  virtual void update(const std::string& /*stage*/, double /*fraction*/,
                      const std::string& /*detail*/) {}
  /// Something the user should know and that does not stop the work.
  virtual void warn(const std::string& /*sentence*/) {}
};

}  // namespace kappamu
