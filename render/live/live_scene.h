// A scene whose lights move and whose volumes are edited: what does not depend on them is prepared
// once, and every question is answered by the objects' exitance.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/options/options.h"
#include "core/progress.h"
#include "render/picture/shading.h"
#include "render/scene/scene.h"
#include "render/scene/world.h"

namespace kappamu::render {

struct LiveOptions {
  std::optional<std::string> model;  ///< in the registry; none: the first of live_models()
  std::optional<double> tolerance;   ///< of models that refine; none: 0.1
  std::string device = "auto";
  std::uint64_t seed = 1;
  OptionValues parameters{};  ///< the model's own
};

/// Those with the ability `live` that can answer for these objects: first those for boxes or
/// homogeneous objects alone, which are faster, then the others, each in the registry's order.
std::vector<std::string> live_models(const World& world);

/// What light comes from where, and what the objects are made of.
struct LiveQuestion {
  std::vector<Light> lights;  ///< the scene's, those with a place or direction moved as one likes
  /// Of objects that are edited. Where a homogeneous one becomes a volume and the model answers for
  /// homogeneous ones alone, the first of live_models() takes its place.
  std::map<std::size_t, ObjectMedia> media;
  std::string model{};  ///< that answers from now on; "": as before
};

/// One answer; what it cost is wall time.
struct LiveAnswer {
  std::vector<ObjectExitance> exitance;  ///< one per object
  double light_ms = 0.0, model_ms = 0.0;
  std::string model;    ///< that answered
  std::string refused;  ///< why the model asked for did not; empty: it did
  /// Worst relative error that the model estimates of its numerics. A model that keeps what it can
  /// from light to light has it measured, for the first lights answered.
  double error_estimate = 0.0;
  int iterations = 0;     ///< of the linear solver; 0 where there is none
  double residual = 0.0;  ///< that it left, relative; 0 where a model does not state it
  bool converged = true;
};

class LiveScene {
 public:
  /// Reads what the scene names and prepares its models. Throws InputError as World does, and
  /// for a model that does not answer for these objects.
  LiveScene(const Scene& scene, const LiveOptions& options, std::vector<std::string>& warnings);
  ~LiveScene();

  const World& world() const { return world_; }
  const std::string& model() const { return model_; }  ///< not while answer() is at work

  /// The scene's environment stays as it is. A light inside an object lights nothing. Media stay
  /// until others are asked for.
  LiveAnswer answer(const LiveQuestion& question, Progress& progress);

 private:
  struct Solver;

  void start(const std::string& model, const OptionValues& parameters);
  void set_media(std::size_t object, const ObjectMedia& media);

  World world_;
  std::string model_;
  LiveOptions options_;
  /// Irradiance of the environment on each object's triangles, R, G, B; empty: none.
  std::vector<std::array<std::vector<double>, 3>> diffuse_;
  std::vector<std::unique_ptr<Solver>> solvers_;
};

}  // namespace kappamu::render
