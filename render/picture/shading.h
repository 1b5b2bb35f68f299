// Radiance that objects send to a camera: what diffusion lets out of them, refracted; light
// scattered once, in its own direction; and reflection at their surface.
//
// Exitance M holds all scattered light. Its part M₁ scattered once leaves in the direction that
// single scattering gives it, the rest as P1 light does:
//   L(θ) = ℓ(θ)·(M − E_t − M₁) + (1−R(θ))/η²·(E_t/(π(1−R_φ)) + L₁),   ℓ: radiance_per_exitance,
// E_t being the diffuse irradiance transmitted inwards there (docs/theory.md) and L₁ the inside
// radiance scattered once. L₁ and M₁ are of the lights with a direction, an environment's lamps
// among them where they enter as beams; M₁ = ∫ (1−R)/η² L₁ cosθ
// dω is estimated per triangle, as M is, so that exitance is conserved.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/progress.h"
#include "render/light/environment.h"
#include "render/picture/ggx.h"
#include "render/picture/single_scattering.h"

namespace kappamu::render {

/// What a model answers for one object, R, G, B.
struct ObjectExitance {
  std::array<std::vector<double>, 3> exitance;  ///< scattered light, per triangle
  std::array<std::vector<double>, 3> diffuse;   ///< irradiance before Fresnel; empty: none
};

class Shading {
 public:
  /// Keeps references to all but `exitance`, which is one per object. With an `eye` given, objects
  /// are seen from there alone. `progress` hears of the work on M₁, and may end it.
  Shading(const World& world, const LightSources& sources, const Environment* environment,
          const std::vector<ObjectExitance>& exitance,
          const std::optional<Eigen::Vector3d>& eye = std::nullopt, Progress* progress = nullptr);
  virtual ~Shading() = default;

  struct Seen {
    Colour radiance = Colour::Zero();
    bool object = false;  ///< else what is behind the objects
  };
  /// Along a ray from outside the objects; the mean over `sample` is of low discrepancy.
  virtual Seen seen(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                    std::uint32_t sample, std::uint64_t key) const;

 private:
  struct Point {
    WorldHit hit;
    Eigen::Vector3d normal;  ///< interpolated, with bumps; outward
    Eigen::Vector3d view;    ///< towards the camera
    double cosine = 1.0;     ///< of both
    double roughness = 0.1;
    Colour reflectance = Colour::Zero();  ///< diffuse, of the surface
  };
  struct Corners {
    std::vector<std::array<Eigen::Vector3d, 3>> normal;  ///< world's frame
    std::vector<std::array<Colour, 3>> outflow;          ///< M − E_t
    std::vector<std::array<Colour, 3>> entering;         ///< E_t; empty: none
    std::vector<std::array<Colour, 3>> once;             ///< M₁; empty: none
  };

  Point point_at(const WorldHit& hit, const Eigen::Vector3d& direction) const;
  Colour scattered(const Point& point, const Colour& once) const;
  std::vector<Colour> exitance_once(std::size_t object, const std::optional<Eigen::Vector3d>& eye,
                                    Progress* progress) const;
  Colour scattered_once(const WorldHit& hit, const Eigen::Vector3d& view, std::uint32_t sample,
                        std::uint64_t key) const;
  Colour through(const WorldHit& hit, const Eigen::Vector3d& view) const;
  Colour emitted(const WorldHit& hit, const Eigen::Vector3d& view, std::uint32_t sample,
                 std::uint64_t key) const;
  Colour reflected(const Point& point, std::uint32_t sample, std::uint64_t key) const;
  Colour reflected_lights(const Point& point, const Ggx& surface,
                          const Eigen::Matrix3d& frame) const;
  Colour reflected_diffusely(const Point& point, std::uint32_t sample, std::uint64_t key) const;
  /// Whether lights have a direction.
  bool directed() const {
    return !sources_.empty() || (environment_ != nullptr && environment_->has_beams());
  }
  /// A direction of the environment's lamps as a light of this sample; none: it has no lamps.
  std::optional<Arrival> lamp(std::uint32_t sample, std::uint64_t key) const;
  Colour reflected_surroundings(const Point& point, const Ggx& surface,
                                const Eigen::Matrix3d& frame, double u, double v) const;

  const World& world_;
  const LightSources& sources_;
  const Environment* environment_;
  SingleScattering single_;
  std::vector<Corners> corners_;
};

}  // namespace kappamu::render
