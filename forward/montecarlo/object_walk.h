// A photon's way through an object: Woodcock tracking (Woodcock et al. 1965) with isotropic
// scattering between refractions at triangles. docs/montecarlo.md, "Objects".
//
// Weights are integers, full_weight at entry; what a photon loses is added to a tally, so that
// entering = leaving + absorbed to the unit. Random numbers are a function of (seed, light, photon,
// event) alone.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "forward/light/walls.h"
#include "forward/montecarlo/philox.h"

namespace kappamu::forward {

/// What does not change from photon to photon.
struct WalkScene {
  WalkScene(const ObjectProblem& problem, const ObjectOptions& options);

  const Surface& surface;
  MeshWalls walls;
  const RayCaster& rays;
  const ObjectMedium& medium;
  double eta;
  bool follow_reentry;
  Eigen::AlignedBox3d box;  ///< of the mesh
  double mean_step = 0.0;   ///< 1/majorant, the medium's largest σt' [mm]
};

/// Where and how a photon begins, inside the surface.
struct WalkStart {
  int triangle = 0;
  Eigen::Vector3d position, direction;
  bool scattered = false;  ///< counts as scattered light from the start
  bool inside = false;     ///< away from all triangles, `triangle` lies ahead
};

struct Exit {
  int triangle = 0;
  std::uint32_t weight = 0;
};

/// Of one photon or many; sums of weights.
struct WalkTally {
  std::uint64_t entered_again = 0;  ///< went out and was refracted in again
  std::uint64_t absorbed = 0, unscattered = 0;
  std::uint64_t reentering = 0;  ///< went out and met the object again, refracted in or not
  std::uint64_t slipped = 0;     ///< left by rounding at an edge; counted among the exits, too
  std::uint64_t tentative = 0, collisions = 0;  ///< numbers of events, of them real ones

  WalkTally& operator+=(const WalkTally& other);
};

class PhotonWalk {
 public:
  PhotonWalk(const WalkScene& scene, PhiloxKey seed, std::uint32_t light)
      : scene_(scene), key_(seed), light_(light) {}

  /// A block of random numbers of the photon's next event.
  PhiloxBlock draw() { return philox({photon_, event_++, light_, 0}, key_); }
  void begin(std::uint32_t photon) {
    photon_ = photon;
    event_ = 0;
  }

  /// Follows the photon that began to its end. Appends where scattered light leaves to `exits`.
  /// Throws InputError where the medium has no scattering left (3κμ > 1).
  void follow(const WalkStart& start, std::vector<Exit>& exits, WalkTally& tally);

 private:
  /// At a tentative collision: loses what is absorbed, turns where it is real.
  void collide(const PhiloxBlock& r, WalkTally& tally);
  /// Turns inwards, or goes outside and perhaps comes in again.
  void meet_surface(std::vector<Exit>& exits, WalkTally& tally);
  void go_outside(WalkTally& tally);
  /// Counts what leaves by a triangle; ends nothing.
  void leave(int triangle, std::vector<Exit>& exits, WalkTally& tally) const;
  bool reflected(double reflectance);
  const Eigen::Vector3d& normal() const {
    return scene_.surface.normal[static_cast<std::size_t>(last_triangle_)];
  }

  const WalkScene& scene_;
  PhiloxKey key_;
  std::uint32_t light_;
  std::uint32_t photon_ = 0, event_ = 0;

  Eigen::Vector3d position_, direction_;
  std::optional<int> triangle_;  ///< the one it lies on
  int last_triangle_ = 0;        ///< the one it lay on last
  std::optional<RayHit> ahead_;  ///< the wall it flies to, where that is known
  std::uint32_t weight_ = 0;     ///< 0: it has ended
  bool scattered_ = false;
};

}  // namespace kappamu::forward
