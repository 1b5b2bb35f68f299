#include "forward/dipole/local/local_sum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"
#include "forward/dipole/local/radius.h"

namespace kappamu::forward::dipole {

namespace {

/// Of the object's size: surfaces nearer to each other along a ray count as one.
constexpr double skin = 1e-6;

bool sees(const ObjectProblem& problem, const Eigen::Vector3d& eye, const Eigen::Vector3d& point) {
  return !problem.rays.first_hit(eye, point - eye, 0.0, 1.0 - skin);
}

}  // namespace

struct LocalSum::Receiver {
  Eigen::Vector3d at, normal;
  const Eigen::Vector3d* eye = nullptr;  ///< of image space
};

struct LocalSum::Sample {
  std::size_t triangle = 0;
  Eigen::Vector3d at;
};

LocalSum::LocalSum(const ObjectProblem& problem, const Profile& profile,
                   std::span<const double> irradiance)
    : problem_(problem),
      profile_(profile),
      irradiance_(irradiance),
      reflectance_(profile.reflectance()),
      diameter_(bounding_box(problem.mesh).diagonal().norm()) {
  double power = 0.0, area = 0.0;
  for (std::size_t t = 0; t < irradiance.size(); ++t) {
    power_.push_back(power += irradiance[t] * problem.surface.area[t]);
    area_.push_back(area += problem.surface.area[t]);
  }
}

double LocalSum::exitance(std::size_t triangle, const SampleCounts& counts,
                          std::uint64_t key) const {
  return sum({problem_.surface.position[triangle], problem_.surface.normal[triangle]}, counts, key);
}

double LocalSum::exitance_seen(std::size_t triangle, const SampleCounts& counts, std::uint64_t key,
                               const Eigen::Vector3d& eye) const {
  return sum({problem_.surface.position[triangle], problem_.surface.normal[triangle], &eye}, counts,
             key);
}

double LocalSum::sum(const Receiver& receiver, const SampleCounts& counts,
                     std::uint64_t key) const {
  if (power_.empty() || power_.back() <= 0.0) return 0.0;
  const Eigen::Vector3d one = receiver.normal.unitOrthogonal();
  const Eigen::Vector3d other = receiver.normal.cross(one);
  std::vector<Sample> samples;
  for (int i = 0; i < counts.importance; ++i) {
    const auto [u, v] = sobol_point(static_cast<std::uint32_t>(i), key);
    const double r = sampled_radius(profile_, u), angle = 2.0 * std::numbers::pi * v;
    project(receiver, receiver.at + r * (std::cos(angle) * one + std::sin(angle) * other), samples);
  }
  const auto draw = [&](int count, const std::vector<double>& cumulative, std::uint64_t own) {
    for (int i = 0; i < count; ++i) {
      const Sample sample = drawn(cumulative, static_cast<std::uint32_t>(i), key_of({key, own}));
      if (receiver.eye && !sees(problem_, *receiver.eye, sample.at)) continue;
      samples.push_back(sample);
    }
  };
  draw(counts.light, power_, 1);
  draw(counts.uniform, area_, 2);
  double total = 0.0;
  for (const Sample& sample : samples) {
    const double irradiance = irradiance_[sample.triangle];
    if (irradiance == 0.0) continue;
    const double sent = irradiance * profile_.value((sample.at - receiver.at).norm());
    total += sent / density(receiver, sample, counts);
  }
  return total;
}

void LocalSum::project(const Receiver& receiver, const Eigen::Vector3d& in_plane,
                       std::vector<Sample>& samples) const {
  const RayCaster& rays = problem_.rays;
  if (receiver.eye) {
    const Eigen::Vector3d along = in_plane - *receiver.eye;
    if (const auto hit = rays.first_hit(*receiver.eye, along)) {
      samples.push_back(
          {static_cast<std::size_t>(hit->triangle), *receiver.eye + hit->distance * along});
    }
    return;
  }
  const Eigen::Vector3d from = in_plane + diameter_ * receiver.normal;
  double last = 0.0;
  while (const auto hit = rays.first_hit(from, -receiver.normal, last)) {
    samples.push_back(
        {static_cast<std::size_t>(hit->triangle), from - hit->distance * receiver.normal});
    last = hit->distance + skin * diameter_;
  }
}

double LocalSum::density(const Receiver& receiver, const Sample& sample,
                         const SampleCounts& counts) const {
  const Eigen::Vector3d& normal = problem_.surface.normal[sample.triangle];
  double result =
      counts.light * irradiance_[sample.triangle] / power_.back() + counts.uniform / area_.back();
  if (counts.importance == 0) return result;
  double jacobian = 0.0;  // dA' of the tangent plane over dA of the surface
  Eigen::Vector3d in_plane;
  if (receiver.eye) {
    const Eigen::Vector3d along = sample.at - *receiver.eye;
    const double slope = receiver.normal.dot(along);
    const double t = receiver.normal.dot(receiver.at - *receiver.eye) / slope;
    if (!(t > 0.0 && std::isfinite(t))) return result;
    in_plane = *receiver.eye + t * along;
    jacobian = t * t * std::abs(normal.dot(along) / slope);
  } else {
    in_plane = sample.at - receiver.normal.dot(sample.at - receiver.at) * receiver.normal;
    jacobian = std::abs(normal.dot(receiver.normal));
  }
  return result + counts.importance * jacobian * profile_.value((in_plane - receiver.at).norm()) /
                      reflectance_;
}

LocalSum::Sample LocalSum::drawn(const std::vector<double>& cumulative, std::uint32_t index,
                                 std::uint64_t key) const {
  const auto [which, v] = sobol_point(index, key);
  const double w = sobol_point(index, mix(key))[0];
  const auto found =
      std::upper_bound(cumulative.begin(), cumulative.end(), which * cumulative.back());
  const std::size_t t =
      std::min(static_cast<std::size_t>(found - cumulative.begin()), cumulative.size() - 1);
  const auto corner = [&](std::size_t c) -> const Eigen::Vector3d& {
    return problem_.mesh.vertices[static_cast<std::size_t>(problem_.mesh.triangles[t][c])];
  };
  const double root = std::sqrt(v);
  return {t, (1.0 - root) * corner(0) + root * ((1.0 - w) * corner(1) + w * corner(2))};
}

std::vector<bool> seen_from(const ObjectProblem& problem, const Eigen::Vector3d& eye) {
  std::vector<char> seen(problem.surface.size());
  for_rows(static_cast<int>(seen.size()), [&](int row) {
    const auto t = static_cast<std::size_t>(row);
    const Eigen::Vector3d& at = problem.surface.position[t];
    seen[t] = problem.surface.normal[t].dot(eye - at) > 0.0 && sees(problem, eye, at) ? 1 : 0;
  });
  return {seen.begin(), seen.end()};
}

}  // namespace kappamu::forward::dipole
