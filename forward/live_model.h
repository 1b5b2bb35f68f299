// An object under light that moves: what a model keeps from one answer to the next.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "forward/object_model.h"

namespace kappamu::forward {

using LightOfChannels = std::array<ObjectLight, 3>;             ///< R, G, B
using ExitanceOfChannels = std::array<std::vector<double>, 3>;  ///< per triangle
using MediaOfChannels = std::array<std::shared_ptr<const ObjectMedium>, 3>;

/// An object in its three media, which may change between answers, as may the places of its
/// vertices: LiveModel::follow().
struct LiveBody {
  const TriangleMesh& mesh;
  const Surface& surface;  ///< surface_of(mesh)
  const RayCaster& rays;   ///< of the mesh
  const MediaOfChannels& media;
  double eta = 1.3;
  const Polycube* polycube = nullptr;  ///< that a person has drawn
};

/// One light's problem in each of three channels; refers to object and light.
class ChannelProblems {
 public:
  ChannelProblems(const LiveBody& object, const LightOfChannels& light) {
    for (std::size_t c = 0; c < 3; ++c) {
      lights_[c] = {light[c]};
      problems_.push_back({object.mesh, object.surface, object.rays, *object.media[c], object.eta,
                           lights_[c], object.polycube});
    }
  }
  std::span<const ObjectProblem> all() const { return problems_; }
  const ObjectProblem& operator[](std::size_t channel) const { return problems_[channel]; }

 private:
  std::array<std::vector<ObjectLight>, 3> lights_;
  std::vector<ObjectProblem> problems_;
};

class LiveModel {
 public:
  struct Answer {
    ExitanceOfChannels exitance;
    std::size_t elements = 0;  ///< cells or triangles
    int iterations = 0;        ///< of the slowest channel
    double residual = 0.0;     ///< of the worst channel, relative, by the solver's measure
    bool converged = true;
  };

  virtual ~LiveModel() = default;

  /// How finely it can answer: level 0 is coarse and keeps up with lights that move, each further
  /// one is finer and made when it is first asked for.
  virtual int levels() const { return 1; }
  /// At level 0, beams closer than this change the answer no more [mm]; 0, and at finer levels:
  /// those of incident_light() do.
  virtual double beam_spacing_mm() const { return 0.0; }
  /// Starts from the level's last answer. Throws InputError where the object has no such level.
  virtual Answer solve(const LightOfChannels& light, int level, Progress& progress) = 0;
  /// Relative error of `fine`, the answer at `level` to this light; `coarse`: that at the level
  /// before, empty at level 0. None: a finer level knows.
  virtual std::optional<double> measured_error(const LightOfChannels& light, int level,
                                               const ExitanceOfChannels& fine,
                                               const ExitanceOfChannels& coarse) const = 0;

  /// The body's mesh, surface and rays are of another shape of the same triangles. Catching up
  /// takes some `most_ms` at most, as far as the model can bound it; finer levels are made anew.
  /// False: the model cannot follow and has to be made anew.
  virtual bool follow(double /*most_ms*/) { return false; }
  /// Whether answers are of the shape as it is, and not of one that is still to be caught up with.
  virtual bool caught_up() const { return true; }
};

}  // namespace kappamu::forward
