// The scenes that models of objects are compared on: shapes × materials × sizes over the mean free
// path, under one light.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "forward/object_model.h"
#include "render/scene/world.h"

namespace kappamu::studies {

/// Of irradiance 1: parallel from a direction, or even and diffuse from everywhere.
enum class CaseLight { aslant, side, below, sky };

struct ObjectCase {
  std::string name;      ///< "<shape>-<material>-<size>", "-<light>" behind it unless aslant
  std::string shape;     ///< a named shape, one made of it, or a mesh file's stem
  std::string material;  ///< a published one, its red channel; "block": a measured volume
  double size = 0.0;     ///< longest edge of the box over the mean free path
  CaseLight light = CaseLight::aslant;
  std::filesystem::path file = {};  ///< of the mesh, where it is the user's
};

/// What the choice of a model is tuned on, and what it is reported on: other shapes, or other
/// materials, sizes and lights.
enum class Population { tuning, validation };

/// All of a population, or of both those whose names begin with one of `wanted`; throws InputError
/// where none does.
std::vector<ObjectCase> object_cases(Population population, const std::vector<std::string>& wanted);

/// Of `count` cases of any shape, material, size of 10 to 70 and light, drawn by `seed`, those
/// whose names begin with one of `wanted`; all where that is empty.
std::vector<ObjectCase> drawn_cases(int count, std::uint64_t seed,
                                    const std::vector<std::string>& wanted = {});

/// Each file's object in marble of 8, 24 and 72 mean free paths and in skin2 of 24, named by its
/// stem.
std::vector<ObjectCase> cases_of_files(const std::vector<std::string>& files);

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
/// box. Triangles are as large as `edges_per_size` along the longest edge allow; a named shape's
/// own facets are as many, or `facets_per_size`, and flat where triangles are smaller.
ObjectBench make_object_bench(const ObjectCase& object, const std::filesystem::path& meshes,
                              const std::filesystem::path& volume, Progress& progress,
                              int edges_per_size = 64,
                              std::optional<int> facets_per_size = std::nullopt);

}  // namespace kappamu::studies
