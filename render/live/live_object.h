// An object under light that moves: what a model keeps from one answer to the next.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "forward/object_model.h"
#include "render/scene/world.h"

namespace kappamu::render {

using LightOfChannels = std::array<forward::ObjectLight, 3>;    ///< R, G, B
using ExitanceOfChannels = std::array<std::vector<double>, 3>;  ///< per triangle
using MediaOfChannels = std::array<std::shared_ptr<const ObjectMedium>, 3>;

/// One light's problem in each of three channels.
struct ChannelProblems {
  ChannelProblems(const WorldObject& object, const LightOfChannels& light);

  std::array<std::vector<forward::ObjectLight>, 3> lights;
  std::vector<forward::ObjectProblem> of;  ///< refers to `lights` and the object
};

/// Keeps a reference to its object, whose media may change between answers, not its mesh.
class LiveObject {
 public:
  struct Answer {
    ExitanceOfChannels exitance;
    int iterations = 0;     ///< of the slowest channel
    double residual = 0.0;  ///< of the worst channel, relative, by the solver's measure
    bool converged = true;
  };

  virtual ~LiveObject() = default;

  /// Beams closer than this change the answer no more [mm]; 0: those of incident_light() do.
  virtual double beam_spacing_mm() const { return 0.0; }
  virtual Answer solve(const LightOfChannels& light) = 0;
  /// Relative error of an answer by solve(), by a finer one.
  virtual double measured_error(const LightOfChannels& light,
                                const ExitanceOfChannels& exitance) const = 0;
};

/// By a model's name: `grid` (boxes of whole voxels), `polygrid` or `dipole-rotated` (homogeneous
/// objects); none for a model that keeps nothing. Throws InputError where the model cannot answer
/// for the object.
std::unique_ptr<LiveObject> make_live_object(const std::string& model, const WorldObject& object,
                                             const forward::ObjectOptions& options);

}  // namespace kappamu::render
