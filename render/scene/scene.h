// A scene as its file states it (docs/scene.md, docs/scene.schema.json): objects, lights, camera,
// film and the model that computes their light. World frame: right-handed, y up, lengths in mm.
// Radiometric quantities are relative to one unit of irradiance, per channel R, G, B.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/options/options.h"
#include "render/colour.h"
#include "render/deform/deformation.h"
#include "render/edit/light_change.h"
#include "render/hair/fur.h"
#include "render/material/homogeneous.h"
#include "render/material/pattern.h"
#include "render/material/shell.h"
#include "render/surface/surface_detail.h"

namespace kappamu::render {

/// κ and μ of a measured volume, placed in the object.
struct VolumeMaterial {
  enum class Placement { stretch, repeat, mirror, shell };

  std::filesystem::path volume;  ///< a run folder, a fit folder, a folder of arrays, or a .vdb file
  Placement placement = Placement::stretch;  ///< to the object's box; or at true scale; or wrapped
  Shell shell{};                             ///< where wrapped
  /// Of the volume in the object's frame, about x, then y, then z [degrees].
  Eigen::Vector3d turn_deg = Eigen::Vector3d::Zero();
  Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();  ///< of the volume, after the turn
};

struct ComposedMaterial;
using Material =
    std::variant<VolumeMaterial, HomogeneousMaterial, std::shared_ptr<const ComposedMaterial>>;

struct Finish {
  std::optional<double> eta;  ///< relative refractive index; none: the material's, or 1.3
  double roughness = 0.1;     ///< α of GGX; 0: a mirror
  SurfaceDetail detail{};
};

struct SceneObject {
  std::string name;
  std::variant<std::filesystem::path, std::string> shape;  ///< a mesh file, or a named shape
  /// A mesh file whose box is fitted to `size_mm` and the origin instead: one of a sequence.
  std::optional<std::filesystem::path> fitted_as;
  std::vector<double> morph;         ///< weights of a glTF mesh's morph targets
  std::optional<double> proportion;  ///< of a named shape (core/mesh/shapes.h)
  /// Of the bounding box: its longest edge, the shape keeping its proportions; or all three.
  std::variant<double, Eigen::Vector3d> size_mm = 1.0;
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();  ///< of that box's centre
  Eigen::Vector3d turn_deg = Eigen::Vector3d::Zero();     ///< about x, then y, then z
  Material material;
  std::optional<std::filesystem::path> edits;  ///< a recipe (render/edit/edit.h) for its material
  Finish finish;
  Colour emission = Colour::Zero();  ///< of all its volume, even in all directions [1/mm]
  std::optional<std::filesystem::path> polycube;  ///< that a person has drawn of it
  std::optional<Fur> fur;
  std::vector<Deformation> deform;  ///< of the mesh that the fields above make, in this order
  /// Of an object with `edits`: its deformations before those of the edits.
  std::vector<Deformation> deform_unedited;
  int edges_per_size = 64;             ///< no triangle's edge is longer than 1.5 of them
  std::optional<int> facets_per_size;  ///< of a named shape; none: as many as edges
};

/// Materials of one object. Its refractive index is the first's.
struct ComposedMaterial {
  /// By depth below the surface: thicknesses of all layers but the last, outermost first [mm].
  struct Layers {
    std::vector<double> thickness_mm;
  };
  /// Bodies inside: their shapes, sizes and places in the object's frame; the last of those that
  /// overlap counts, each with its own material. `materials` holds the one around them.
  struct Parts {
    std::vector<SceneObject> parts;
  };

  std::vector<Material> materials;
  /// Of two materials by a pattern: σs' and μ are mixed, the second's by its share.
  std::variant<Pattern, Layers, Parts> by;
};

struct DirectionalLight {
  Eigen::Vector3d direction = -Eigen::Vector3d::UnitY();  ///< of travel
  Colour irradiance = Colour::Ones();                     ///< on a surface that faces the light
};

/// Lights at a place state their irradiance on a surface that faces them `at_mm` away.
struct PointLight {
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
  Colour irradiance = Colour::Ones();
  double at_mm = 1.0;
};

struct SpotLight {
  PointLight point;
  Eigen::Vector3d target_mm = Eigen::Vector3d::Zero();
  double cone_deg = 30.0;  ///< full angle outside which there is no light
  double edge_deg = 3.0;   ///< over which the light falls off at the cone's edge
};

/// A pinhole that throws an image; white pixels give `point.irradiance` on the axis.
struct ProjectorLight {
  PointLight point;
  Eigen::Vector3d target_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();
  double fov_deg = 30.0;  ///< of the image's height
  std::filesystem::path image;
};

/// Light from everywhere: a latitude-longitude image (top row: +y, centre: −z), or constant.
struct EnvironmentLight {
  std::optional<std::filesystem::path> image;
  Colour radiance = Colour::Ones();  ///< factor on the image, or the constant radiance
  double turn_deg = 0.0;             ///< about y
  bool visible = true;               ///< to the camera, behind the objects
};

using Light =
    std::variant<DirectionalLight, PointLight, SpotLight, ProjectorLight, EnvironmentLight>;

struct Camera {
  Eigen::Vector3d position_mm = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d target_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();
  double fov_deg = 30.0;  ///< of the film's height

  bool operator==(const Camera&) const = default;
};

struct Film {
  int width = 640, height = 480;  ///< [px]
  int samples = 64;               ///< camera rays per pixel
  std::optional<double>
      exposure;  ///< factor before the tone curve of the PNG; none: by the picture
};

struct ModelChoice {
  std::string name = "embedded";              ///< in the registry
  double tolerance = 0.02;                    ///< relative error of the exitance asked for
  bool follow_reentry = false;                ///< light that leaves an object and meets it again
  std::optional<std::uint64_t> max_elements;  ///< of a model that refines; none: what memory holds
  OptionValues parameters;                    ///< the model's own, where the scene states them
};

struct Scene {
  std::filesystem::path file;  ///< relative names in it are relative to its folder
  std::vector<SceneObject> objects;
  std::vector<Light> lights;
  Camera camera;
  Film film;
  ModelChoice model;
};

/// The scene's own and those it names: meshes, volumes, images.
std::vector<std::filesystem::path> files_of(const Scene& scene);

/// Whether it is no scene but what one begins with (new_scene.h): a folder, a volume or a mesh.
bool begins_scene(const std::filesystem::path& path);

/// Throws InputError naming file, field and fix.
Scene read_scene(const std::filesystem::path& file);
/// Of a text that stands for the file; messages name the file and `which` of its texts it is.
Scene read_scene(const std::string& text, const std::filesystem::path& file,
                 const std::string& which);

/// Whether all their fields are equal.
bool same(const Light& a, const Light& b);

/// What makes lights `after` of lights `before`, which are the same kinds in the same order.
LightChanges light_changes(const std::vector<Light>& before, const std::vector<Light>& after);
/// Makes them. Throws InputError naming `origin` and the light where there is none of that number,
/// or it is of another kind.
void change_lights(const LightChanges& changes, const std::string& origin,
                   std::vector<Light>& lights);
/// Throws InputError naming both origins where they give a field of a light two values.
void expect_agreement(const LightChanges& changes, const std::string& origin,
                      const LightChanges& others, const std::string& other_origin);

}  // namespace kappamu::render
