// What a rig's driver implements: place something before camera and projector, show an image,
// expose a frame. capture/rig/shoot.h drives a whole session through it; the simulator is one
// driver, a real rig's place() asks its operator.
#pragma once

#include <cstdint>
#include <string>

#include "capture/session/session.h"
#include "core/image.h"

namespace kappamu::capture {

/// What stands before the rig.
enum class Subject {
  sample,        ///< the sample in its place
  board,         ///< the printed chessboard by itself, in pose Scene::pose
  plane,         ///< a plane with the printed board and a blank part, in pose Scene::pose
  white_target,  ///< the diffuse white in the plane of the lit face, covering it
  colour_chart,  ///< the ColorChecker in the same plane
  lens_covered   ///< no light reaches the camera
};

/// What lights the subject.
enum class Lighting {
  projector,  ///< the room is dark
  room,       ///< the room's lamps: even light on the subject, dark background
  none        ///< projector off, or its lens capped: not even its black reaches the subject
};

/// One unchanging arrangement of subject, camera station and room light.
struct Scene {
  Subject subject = Subject::sample;
  std::string station;  ///< camera station, one of the plan's two
  Lighting lighting = Lighting::projector;
  int pose = 0;   ///< board and plane: which pose, 0 ... poses - 1; otherwise 0
  int poses = 1;  ///< how many poses the series has, so that a driver can spread them
};

/// Driver of one rig. Failures are thrown as InputError.
class RigDevice {
 public:
  RigDevice() = default;
  RigDevice(const RigDevice&) = delete;
  RigDevice& operator=(const RigDevice&) = delete;
  virtual ~RigDevice() = default;

  virtual Camera camera() const = 0;
  virtual Projector projector() const = 0;

  /// Arranges `scene`; it then stays as it is until the next call. The projector goes black.
  virtual void place(const Scene& scene) = 0;

  /// Shows an image of one channel and the projector's size until the next show() or place();
  /// 0 dark, 255 full white, light proportional to the value.
  virtual void show(const Image<std::uint8_t>& image) = 0;

  /// Takes one frame: code values 0 ... 2^bit_depth - 1 of the camera's size, channels R, G,
  /// B. `exposure_s` [s] > 0.
  virtual Image<std::uint16_t> expose(double exposure_s) = 0;
};

}  // namespace kappamu::capture
