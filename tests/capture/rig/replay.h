// A driver that photographs nothing: it hands out the frames of a session folder as if a rig took
// them now. For trying a plan or a program without a rig, and the example to write a driver from.
#pragma once

#include <filesystem>

#include "capture/rig/device.h"
#include "capture/session/session.h"

namespace kappamu::capture {

/// Throws InputError for whatever the session's folder has no photograph of.
class FolderReplay : public RigDevice {
 public:
  /// `folder` holds a session.json and its photographs.
  explicit FolderReplay(const std::filesystem::path& folder);

  Camera camera() const override { return session_.camera; }
  Projector projector() const override { return session_.projector; }
  void place(const Scene& scene) override;
  void show(const Image<std::uint8_t>& image) override;
  /// The photograph of the scene, the shown image and this exposure time. Of a single, metered
  /// photograph a longer time gives a white frame: it was not taken because it saturated. Equal
  /// exposures (dark frames) are handed out in turn.
  Image<std::uint16_t> expose(double exposure_s) override;

 private:
  std::vector<Frame> frames_of_scene() const;
  const Pattern* shown_pattern() const;

  Session session_;
  Scene scene_;
  Image<std::uint8_t> shown_;
  std::size_t exposed_ = 0;  ///< frames of this scene and image so far
};

}  // namespace kappamu::capture
