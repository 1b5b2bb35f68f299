#include "forward/montecarlo/object_walk.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "core/error.h"
#include "core/optics.h"

namespace kappamu::forward {

namespace {

using Eigen::Vector3d;

constexpr std::uint32_t full_weight = 1U << 31;
/// Lighter photons are absorbed whole or not at all: that ends them without creating energy.
constexpr std::uint32_t light_weight = 1U << 25;
/// Coefficients stored as float may have 3κμ = 1 + 1e-7 where 1 was meant.
constexpr double share_rounding = 1e-6;
/// What a ray caster may need of the box's longest edge to tell a point from the surface.
constexpr double nudge_share = 1e-6;

Vector3d isotropic(double u, double turn) {
  const double cosine = 2.0 * u - 1.0, sine = std::sqrt(1.0 - cosine * cosine);
  const double angle = 2.0 * std::numbers::pi * turn;
  return {sine * std::cos(angle), sine * std::sin(angle), cosine};
}

}  // namespace

WalkScene::WalkScene(const ObjectProblem& problem, const ObjectOptions& options)
    : surface(problem.surface),
      rays(problem.rays),
      medium(problem.medium),
      eta(problem.eta),
      follow_reentry(options.follow_reentry),
      box(bounding_box(problem.mesh)),
      nudge(nudge_share * box.sizes().maxCoeff()),
      mean_step(3.0 * medium.smallest().kappa) {
  box.min().array() -= 10.0 * nudge;
  box.max().array() += 10.0 * nudge;
}

Vector3d WalkScene::nudged(const Vector3d& position, int triangle) const {
  const auto t = static_cast<std::size_t>(triangle);
  const Vector3d to_middle = surface.position[t] - position;
  const double way = to_middle.norm();
  const Vector3d aside = way > nudge ? Vector3d(nudge / way * to_middle) : to_middle;
  return position + aside - nudge * surface.normal[t];
}

WalkTally& WalkTally::operator+=(const WalkTally& other) {
  entered_again += other.entered_again;
  absorbed += other.absorbed;
  unscattered += other.unscattered;
  reentering += other.reentering;
  slipped += other.slipped;
  tentative += other.tentative;
  collisions += other.collisions;
  return *this;
}

Vector3d refracted(const Vector3d& direction, const Vector3d& normal, double eta_ratio) {
  const double cosine = -direction.dot(normal);
  const double beyond =
      std::sqrt(std::max(0.0, 1.0 - eta_ratio * eta_ratio * (1.0 - cosine * cosine)));
  return (eta_ratio * direction + (eta_ratio * cosine - beyond) * normal).normalized();
}

bool PhotonWalk::reflected(double reflectance) {
  if (reflectance <= 0.0 || reflectance >= 1.0) return reflectance > 0.0;
  return uniform_of(draw()[0]) < reflectance;
}

void PhotonWalk::follow(const WalkStart& start, std::vector<Exit>& exits, WalkTally& tally) {
  position_ = start.position;
  direction_ = start.direction;
  triangle_ = last_triangle_ = start.triangle;
  ahead_.reset();
  weight_ = full_weight;
  scattered_ = start.scattered;
  while (weight_ > 0) {
    const PhiloxBlock r = draw();
    const double step = -std::log(uniform_of(r[0])) * scene_.mean_step;
    if (!ahead_) {
      ahead_ =
          triangle_ ? wall_from_surface() : scene_.rays.first_hit(position_, direction_, 0.0, step);
    }
    const bool lost = triangle_ && !ahead_;
    if (!lost && ahead_ && ahead_->distance <= step) {
      position_ += ahead_->distance * direction_;
      triangle_ = last_triangle_ = ahead_->triangle;
      ahead_.reset();
      // From outside only where it slipped past an edge: it comes in again.
      if (normal().dot(direction_) > 0.0) meet_surface(exits, tally);
      continue;
    }
    position_ += step * direction_;
    triangle_.reset();
    if (ahead_) ahead_->distance -= step;
    if (lost || !scene_.box.contains(position_)) {
      tally.slipped += weight_;
      leave(last_triangle_, exits, tally);
      return;
    }
    collide(r, tally);
  }
}

std::optional<RayHit> PhotonWalk::wall_from_surface() {
  constexpr int tries = 4;
  for (int i = 0; i < tries; ++i) {
    std::optional<RayHit> hit = scene_.rays.first_hit(position_, direction_);
    if (hit && hit->triangle == *triangle_) {
      hit = scene_.rays.first_hit(position_, direction_, hit->distance);
    }
    if (hit) {
      const auto t = static_cast<std::size_t>(hit->triangle);
      if (scene_.surface.normal[t].dot(direction_) > 0.0) return hit;
    }
    position_ = scene_.nudged(position_, last_triangle_);
  }
  return std::nullopt;
}

void PhotonWalk::collide(const PhiloxBlock& r, WalkTally& tally) {
  ++tally.tentative;
  const Coefficients here = scene_.medium.at(position_);
  const double real = scene_.mean_step / (3.0 * here.kappa);  // σt'/majorant
  const double absorbed = 3.0 * here.kappa * here.mu;         // σa/σt'
  if (absorbed > 1.0 + share_rounding) {
    std::ostringstream text;
    text << "medium: at (" << position_.transpose() << ") mm kappa = " << here.kappa
         << " and mu = " << here.mu
         << " leave no scattering (3 kappa mu > 1), which Monte Carlo transport cannot read as a "
            "medium; lower kappa or mu there";
    throw InputError(text.str());
  }
  const double u = uniform_of(r[1]);
  if (u >= real) return;
  ++tally.collisions;
  const double chance = std::min(1.0, absorbed);
  if (weight_ >= light_weight) {
    const auto loss = static_cast<std::uint32_t>(std::lround(weight_ * chance));
    tally.absorbed += loss;
    weight_ -= loss;
  } else if (u < real * chance) {
    tally.absorbed += weight_;
    weight_ = 0;
  }
  direction_ = isotropic(uniform_of(r[2]), uniform_of(r[3]));
  ahead_.reset();
  scattered_ = true;
}

void PhotonWalk::meet_surface(std::vector<Exit>& exits, WalkTally& tally) {
  const double cosine = std::min(1.0, normal().dot(direction_));
  if (reflected(fresnel_internal(scene_.eta, cosine))) {
    direction_ = (direction_ - 2.0 * cosine * normal()).normalized();
    return;
  }
  leave(last_triangle_, exits, tally);
  direction_ = refracted(direction_, -normal(), scene_.eta);
  go_outside(tally);
}

void PhotonWalk::leave(int triangle, std::vector<Exit>& exits, WalkTally& tally) const {
  if (scattered_) {
    exits.push_back({triangle, weight_});
  } else {
    tally.unscattered += weight_;
  }
}

void PhotonWalk::go_outside(WalkTally& tally) {
  for (bool first = true;; first = false) {
    std::optional<RayHit> hit = scene_.rays.first_hit(position_, direction_);
    if (hit && hit->triangle == last_triangle_) {
      hit = scene_.rays.first_hit(position_, direction_, hit->distance);
    }
    double cosine = 0.0;
    if (hit) {
      cosine = -scene_.surface.normal[static_cast<std::size_t>(hit->triangle)].dot(direction_);
    }
    if (cosine <= 0.0) break;  // nothing, or a wall from inside: rounding at an edge
    if (first) tally.reentering += weight_;
    if (!scene_.follow_reentry) break;
    position_ += hit->distance * direction_;
    triangle_ = last_triangle_ = hit->triangle;
    if (!reflected(fresnel_external(scene_.eta, std::min(1.0, cosine)))) {
      direction_ = refracted(direction_, normal(), 1.0 / scene_.eta);
      tally.entered_again += weight_;
      return;
    }
    direction_ = (direction_ + 2.0 * cosine * normal()).normalized();
  }
  weight_ = 0;
}

}  // namespace kappamu::forward
