// A scene over time (docs/howto/animate.md): fields of its file that take other values from frame
// to frame. Every frame is the text of a scene of its own, which the scene's reader checks.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "render/scene/scene.h"

namespace kappamu::render {

class Frames {
 public:
  /// How a field goes from one key's value to the next.
  enum class Between { linear, smooth, step };

  /// Keyframes from a file of format kappamu-frames. Throws InputError naming file and field; a
  /// field's value is checked where the frame is read.
  Frames(const std::filesystem::path& scene, const std::filesystem::path& file);
  /// The camera once round its target, about its `up`, in `count` frames.
  Frames(const std::filesystem::path& scene, int count);
  ~Frames();

  int count() const { return count_; }
  double rate() const { return rate_; }  ///< frames a second
  /// The JSON of the scene at a frame, from 0.
  std::string text(int frame) const;
  /// Throws InputError naming the scene's file, frame and field.
  Scene scene(int frame) const;

 private:
  struct Track;

  std::filesystem::path scene_;
  std::unique_ptr<nlohmann::json> json_;  ///< of the scene's file
  int count_ = 1;
  double rate_ = 24.0;
  std::vector<Track> tracks_;
};

}  // namespace kappamu::render
