// The scenes that models of objects are compared on: shapes × materials × sizes over the mean free
// path, under one light.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "forward/object_model.h"
#include "render/scene/world.h"

namespace kappamu::bench {

struct ObjectCase {
  std::string name;      ///< "<shape>-<material>-<size>", "-sky" behind it where that is the light
  std::string shape;     ///< a named shape, or a mesh file's stem
  std::string material;  ///< a published one, its red channel; "block": a measured volume
  double size = 0.0;     ///< longest edge of the box over the mean free path
  bool sky = false;      ///< even diffuse light of irradiance 1; else parallel light, aslant
};

/// All of them, or those whose names begin with one of `wanted`; throws InputError where none does.
std::vector<ObjectCase> object_cases(const std::vector<std::string>& wanted);

/// A case made ready for a model.
struct ObjectBench {
  std::unique_ptr<render::World> world;
  std::vector<forward::ObjectLight> lights;  ///< one
  double power = 0.0;                        ///< that arrives, before Fresnel [mm²]
  double kappa_mm = 0.0, mu_per_mm = 0.0;    ///< means over the material: of 1/κ, and of μ
  double albedo = 0.0;                       ///< σs'/(σs' + μ) of these
  /// 2V/S over the mean free path: the thickness of a slab, two thirds of a sphere's radius.
  double thickness = 0.0;

  const render::WorldObject& object() const { return world->objects().front(); }
  forward::ObjectProblem problem() const;
};

/// Meshes are `meshes`/<shape>.ply; the measured volume is `volume`, stretched over the object's
/// box.
ObjectBench make_object_bench(const ObjectCase& object, const std::filesystem::path& meshes,
                              const std::filesystem::path& volume, Progress& progress);

}  // namespace kappamu::bench
