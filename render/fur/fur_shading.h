// Pictures of furry objects: shells above the skin in the order in which the eye's ray meets them,
// fins between them at the silhouette (Lengyel et al. 2001), skin and all else behind.
//
// Fur scatters light once, what reaches the skin comes out of it again as the model has it, through
// the fur. Fur casts no shadow on other objects, and reflects none of their light.
#pragma once

#include <memory>
#include <vector>

#include "render/embree_caster.h"
#include "render/fur/furry_object.h"
#include "render/picture/shading.h"

namespace kappamu::render {

/// One per object of the world; nullptr: bare.
using Furs = std::vector<std::unique_ptr<FurryObject>>;

class FurShading : public Shading {
 public:
  /// As Shading, with the eye needed for fins. Keeps references.
  FurShading(const World& world, const LightSources& sources, const Environment* environment,
             const std::vector<ObjectExitance>& exitance, const Eigen::Vector3d& eye,
             const Furs& furs);

  Seen seen(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, std::uint32_t sample,
            std::uint64_t key) const override;

 private:
  /// What a triangle of the shells' mesh shows. A fin's layer depends on its height.
  struct Shown {
    int fur = 0, triangle = 0;
    int layer = 0;  ///< of a shell
    bool fin = false;
    bool upper = false;  ///< the fin's second triangle
    int edge = 0;        ///< of `triangle`, on which a fin stands: its first corner
  };
  void add_shells(int fur, TriangleMesh& all);
  void add_fins(int fur, const Eigen::Vector3d& eye, TriangleMesh& all);
  void add_hit(const RayHit& hit, const Eigen::Vector3d& direction,
               forward::shells::SeenHair& sum) const;

  const World& world_;
  const Furs& furs_;
  LightSources no_sources_;
  Shading skin_;  ///< under fur: light comes out, none is reflected
  std::vector<Shown> shown_;
  std::unique_ptr<MovableCaster> shells_;
};

/// A Shading, or a FurShading where an object has fur.
std::unique_ptr<Shading> make_shading(const World& world, const LightSources& sources,
                                      const Environment* environment,
                                      const std::vector<ObjectExitance>& exitance,
                                      const Eigen::Vector3d& eye, const Furs& furs);

}  // namespace kappamu::render
