// One question about objects, many answers: (shape, medium, light) → exitance on the surface, with
// an error estimate, its cost and its warnings. What grids answer for blocks (forward_model.h),
// these models answer for closed triangle meshes.
//
// All irradiances and powers are relative to one unit of irradiance; lengths in mm.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/polycube.h"
#include "core/mesh/triangle_mesh.h"
#include "core/object_medium.h"
#include "core/options/options.h"
#include "core/progress.h"
#include "core/ray_caster.h"

namespace kappamu::forward {

/// A thin collimated beam that meets a triangle from outside, or begins inside and flies to it.
struct Beam {
  int triangle = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< on it, or inside [mm]
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< of travel where it is, of unit length
  double power = 0.0;  ///< before Fresnel; inside: all of it [mm²]
};

/// Light of one source, or of all together.
struct ObjectLight {
  std::vector<Beam> beams;  ///< refracted in; deposit their first collisions inside
  /// Per surface sample, irradiance before Fresnel of the even light of which as much enters;
  /// empty: none.
  std::vector<double> diffuse;
};

struct ObjectProblem {
  const TriangleMesh& mesh;
  const Surface& surface;      ///< surface_of(mesh)
  const RayCaster& rays;       ///< of the mesh
  const ObjectMedium& medium;  ///< one colour channel
  double eta = 1.3;            ///< relative refractive index
  const std::vector<ObjectLight>& lights;
  const Polycube* polycube = nullptr;  ///< that a person has drawn of it, for model `polygrid`
};

/// Seconds on this machine over those of the table (forward/choice/machine_costs.h), by model; a
/// model that is absent counts as 1.
using MachineCosts = std::map<std::string, double>;

/// What every model is asked; what one model alone understands are its own parameters.
struct ObjectOptions {
  double tolerance = 0.02;  ///< relative error of the exitance in the surface's 2-norm, asked for
  std::string device = "auto";
  std::uint64_t seed = 1;
  bool follow_reentry = false;                ///< light that leaves and meets the object again
  std::optional<Eigen::Vector3d> eye;         ///< of the picture, in the object's frame [mm]
  std::optional<std::uint64_t> max_elements;  ///< refuse beyond; none: what memory holds
  MachineCosts costs{};                       ///< for a model that chooses among others
};

/// Where a light's power goes: `unscattered`, `exiting` and `absorbed` sum to `entering`, which is
/// after Fresnel, and `created` [mm²].
struct ObjectBalance {
  double entering = 0.0;
  double unscattered = 0.0;  ///< left again without a collision
  double exiting = 0.0;      ///< left scattered: ∫ exitance dA
  double absorbed = 0.0;
  double created = 0.0;     ///< left without having entered: an error of the dipoles
  double reentering = 0.0;  ///< of what left, the share that meets the object again
};

/// What model `auto` knows of a model for an object.
struct ModelCandidate {
  std::string model;
  /// Relative error against transport that it is not expected to exceed, 2-norm over the surface;
  /// none: it cannot answer, or was not measured on such objects.
  std::optional<double> error;
  std::optional<double> seconds;  ///< expected; none as above
  double photons = 0.0;           ///< of the walks that correct its answer; 0: none do
  std::string reason;             ///< why it was taken or left, one phrase
};

struct ObjectResult {
  std::vector<double> exitance;        ///< [light][sample], scattered light
  std::vector<double> standard_error;  ///< of `exitance`; empty: the model draws no random numbers
  /// Relative 2-norm error of each light's exitance against the model's own limit: of numerics, or
  /// one standard error of random walks by patch of 1/8 of the object (forward/patches.h).
  std::vector<double> error_estimate;
  /// Of each light, what the model itself errs by at most against transport
  /// (forward/model_error.h); empty: nothing.
  std::vector<double> model_error;
  std::vector<ObjectBalance> balance;  ///< one per light
  /// [light]: unscattered, by the triangle that it leaves by and as it goes on outside. Models give
  /// it to one another, an answer has it no more.
  std::vector<std::vector<Beam>> leaving;
  std::size_t elements = 0;  ///< cells, triangles or photons
  int iterations = 0;
  double setup_seconds = 0.0, seconds = 0.0;
  bool converged = false;  ///< the tolerance is met by the model's own estimate
  std::string message;     ///< one sentence: why it stopped
  std::vector<std::string> warnings;
  std::vector<ModelCandidate> candidates;  ///< of model `auto`, the one taken first; else empty

  /// Of numerics and model together.
  double error(std::size_t light) const {
    return std::hypot(error_estimate[light], model_error.empty() ? 0.0 : model_error[light]);
  }
};

class LiveModel;
struct LiveBody;

/// A model and its own parameters. What is known of it before it is made: forward/registry.h.
class ObjectModel {
 public:
  virtual ~ObjectModel() = default;
  /// Visits the model's own parameters, as they are.
  virtual void describe(const OptionVisitor& /*visit*/) {}
  /// Sets parameters by name. Throws InputError for one that the model does not have, naming those
  /// it has, and as set_option() does.
  void set(const OptionValues& parameters);
  OptionValues parameters();
  /// Throws InputError where the problem is outside what the model can answer.
  virtual ObjectResult solve(const ObjectProblem& problem, const ObjectOptions& options,
                             Progress& progress) = 0;
  /// Colour channels at once: one result per problem. The problems share mesh, surface, rays and
  /// eta; models whose work on the shape serves all of them do it once.
  virtual std::vector<ObjectResult> solve_channels(std::span<const ObjectProblem> problems,
                                                   const ObjectOptions& options,
                                                   Progress& progress) {
    std::vector<ObjectResult> results;
    for (const ObjectProblem& problem : problems) {
      results.push_back(solve(problem, options, progress));
    }
    return results;
  }
  /// What the model keeps of an object whose light moves (forward/live_model.h), which outlives
  /// it; none: every light is answered anew.
  virtual std::unique_ptr<LiveModel> keep(const LiveBody& object, const ObjectOptions& options,
                                          Progress& progress);
};

/// A model whose work on the shape serves all channels, and so gives solve_channels() alone.
class ChannelsModel : public ObjectModel {
 public:
  ObjectResult solve(const ObjectProblem& problem, const ObjectOptions& options,
                     Progress& progress) final {
    return solve_channels({&problem, 1}, options, progress).front();
  }
  std::vector<ObjectResult> solve_channels(std::span<const ObjectProblem> problems,
                                           const ObjectOptions& options,
                                           Progress& progress) override = 0;
};

}  // namespace kappamu::forward
