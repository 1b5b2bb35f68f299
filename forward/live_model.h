// An object under light that moves: what a model keeps from one answer to the next.
#pragma once

#include <array>
#include <memory>
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
    int iterations = 0;     ///< of the slowest channel
    double residual = 0.0;  ///< of the worst channel, relative, by the solver's measure
    bool converged = true;
  };

  virtual ~LiveModel() = default;

  /// Beams closer than this change the answer no more [mm]; 0: those of incident_light() do.
  virtual double beam_spacing_mm() const { return 0.0; }
  virtual Answer solve(const LightOfChannels& light) = 0;

  /// The body's mesh, surface and rays are of another shape of the same triangles. Where the model
  /// cannot follow it has to be made anew; `former` is what that one may start from. Catching up
  /// takes some `most_ms` at most, as far as the model can bound it.
  virtual bool follow(double /*most_ms*/) { return false; }
  /// Whether answers are of the shape as it is, and not of one that is still to be caught up with.
  virtual bool caught_up() const { return true; }
  /// Links, cells: what an answer is computed with.
  virtual std::size_t elements() const { return 0; }
  /// Relative error of an answer by solve(), by a finer one.
  virtual double measured_error(const LightOfChannels& light,
                                const ExitanceOfChannels& exitance) const = 0;
};

}  // namespace kappamu::forward
