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
Vector3d isotropic(double u, double turn) {
  const double cosine = 2.0 * u - 1.0, sine = std::sqrt(1.0 - cosine * cosine);
  const double angle = 2.0 * std::numbers::pi * turn;
  return {sine * std::cos(angle), sine * std::sin(angle), cosine};
}

}  // namespace

WalkScene::WalkScene(const ObjectProblem& problem, const ObjectOptions& options)
    : surface(problem.surface),
      walls(problem),
      rays(problem.rays),
      medium(problem.medium),
      eta(problem.eta),
      follow_reentry(options.follow_reentry),
      box(bounding_box(problem.mesh)),
      mean_step(3.0 * medium.smallest().kappa) {
  box.min().array() -= 10.0 * walls.nudge();
  box.max().array() += 10.0 * walls.nudge();
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

bool PhotonWalk::reflected(double reflectance) {
  if (reflectance <= 0.0 || reflectance >= 1.0) return reflectance > 0.0;
  return uniform_of(draw()[0]) < reflectance;
}

void PhotonWalk::follow(const WalkStart& start, std::vector<Exit>& exits, WalkTally& tally) {
  position_ = start.position;
  direction_ = start.direction;
  triangle_ = last_triangle_ = start.triangle;
  if (start.inside) triangle_.reset();
  ahead_.reset();
  weight_ = full_weight;
  scattered_ = start.scattered;
  while (weight_ > 0) {
    const PhiloxBlock r = draw();
    const double step = -std::log(uniform_of(r[0])) * scene_.mean_step;
    if (!ahead_) {
      ahead_ = triangle_ ? scene_.walls.inside(position_, direction_, *triangle_)
                         : scene_.rays.first_hit(position_, direction_, 0.0, step);
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
    direction_ = mirrored(direction_, normal());
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
    const std::optional<RayHit> hit = scene_.walls.outside(position_, direction_, last_triangle_);
    if (!hit) break;
    const double cosine = -scene_.walls.normal(hit->triangle).dot(direction_);
    if (first) tally.reentering += weight_;
    if (!scene_.follow_reentry) break;
    position_ += hit->distance * direction_;
    triangle_ = last_triangle_ = hit->triangle;
    if (!reflected(fresnel_external(scene_.eta, std::min(1.0, cosine)))) {
      direction_ = refracted(direction_, normal(), 1.0 / scene_.eta);
      tally.entered_again += weight_;
      return;
    }
    direction_ = mirrored(direction_, normal());
  }
  weight_ = 0;
}

}  // namespace kappamu::forward
