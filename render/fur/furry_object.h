// The fur of one object: its tile with transfer, laid over the mesh, lit place by place. A vertex
// holds the light that arrives there in the frame of its skin; between vertices it is interpolated.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "forward/shells/lit_hair.h"
#include "render/fur/placement.h"
#include "render/light/environment.h"
#include "render/light/incident_light.h"
#include "render/light/light_source.h"
#include "render/scene/world.h"

namespace kappamu::render {

struct FurReport {
  int hairs = 0;            ///< in a tile
  std::size_t patches = 0;  ///< that lie on the object
  double stretch = 1.0;     ///< largest
  double extinction = 0.0;  ///< r [1/mm]
  double through = 0.0;     ///< share of an even sky's irradiance that reaches the skin
};

/// A tile with its transfer, which knows nothing of the object it lies on.
struct FurTile {
  forward::shells::HairTexture texture;
  forward::shells::Transfer transfer;
  std::vector<double> through;  ///< to the skin, by the cosine with its normal, 0 to 1

  static constexpr int width = 64, layers = 32;
  double through_at(double cosine) const;
  double through_of_even_sky() const;
};
/// Depends on the fur's widths, density, curl, lean, seed, bands, rays, and its length over its
/// tile. Throws InputError naming option and bound.
FurTile make_fur_tile(const Fur& fur, Progress& progress);
/// Whether both have the same tile but for its rays.
bool same_tile(const Fur& a, const Fur& b);

/// Tiles made once for all furs that have the same.
class FurTiles {
 public:
  std::shared_ptr<const FurTile> of(const Fur& fur, Progress& progress);

 private:
  std::vector<std::pair<Fur, std::shared_ptr<const FurTile>>> made_;
};

class FurryObject {
 public:
  FurryObject(const FurryObject&) = delete;
  FurryObject& operator=(const FurryObject&) = delete;

  /// `fur` of the object, whose `report` it fills. Throws InputError naming the object.
  FurryObject(const WorldObject& object, const Fur& fur, FurTiles& tiles, FurReport& report,
              Progress& progress);
  /// With a tile made before, and a coat. Keeps references to object and fur.
  FurryObject(const WorldObject& object, const Fur& fur, std::shared_ptr<const FurTile> tile,
              Coat coat);

  /// What of this fur, under these lamps, seen from there, is beyond what shells can show
  /// (docs/fur.md, Limits).
  void warn(const LightSources& sources, const Eigen::Vector3d& eye,
            std::vector<std::string>& warnings) const;

  /// Of light on the bare skin, what comes through the fur.
  void shade(IncidentLight& light) const;
  /// Lights all places; to be called before seen().
  void set_light(const World& world, const LightSources& sources, const Environment* environment);

  /// A layer of hair above a place of the skin.
  struct Layer {
    Eigen::Array3d radiance;  ///< of its hairs, towards the eye
    double density = 0.0;
  };
  Layer seen(std::size_t triangle, double u, double v, int layer,
             const Eigen::Vector3d& towards_eye) const;
  /// What a layer of that density holds back where its normal and the ray have this cosine.
  double opacity(double density, double cosine) const;

  const Fur& fur() const { return fur_; }
  const WorldObject& object() const { return object_; }
  const std::vector<SkinFrame>& frames() const { return frames_; }
  const Coat& coat() const { return coat_; }
  const FurTile& tile() const { return *tile_; }
  const Placement& placement() const { return *placement_; }
  int layers() const { return tile_->texture.layers; }
  double texel_mm() const { return fur_.tile() / tile_->texture.width; }
  /// Of the longest hairs at a vertex.
  double length_mm(std::size_t vertex) const {
    return fur_.length_mm * static_cast<double>(coat_.length[vertex]);
  }

  /// At a vertex, in its frame.
  struct Irradiance {
    std::vector<Eigen::Array3d> of_lamp;
    Eigen::MatrixXd coefficients;  ///< as PlaceLight's
    std::vector<Eigen::Vector3d> direction;
  };
  const std::vector<Irradiance>& light() const { return light_; }

 private:
  const WorldObject& object_;
  const Fur& fur_;
  std::shared_ptr<const FurTile> tile_;
  Coat coat_;
  forward::shells::HairColour colour_;
  forward::shells::HairReflectance reflectance_;
  std::vector<SkinFrame> frames_;
  std::unique_ptr<Placement> placement_;
  std::vector<Irradiance> light_;  ///< per vertex
};

}  // namespace kappamu::render
