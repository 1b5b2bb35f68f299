#include "render/live/lit_corners.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "render/picture/ggx.h"

namespace kappamu::render {

using Eigen::Vector3d;

namespace {

template <class Value>
void append(const Value& value, std::vector<float>& out) {
  for (Eigen::Index i = 0; i < 3; ++i) out.push_back(static_cast<float>(value[i]));
}

/// M₁ of one object's triangles.
class OnceScattered {
 public:
  OnceScattered(const LiveAnswer& answer, std::size_t index, const WorldObject& object)
      : answer_(answer),
        surface_(answer.surface[index]),
        object_(object),
        table_(exitance_once_scattered(surface_.boundary.eta, steps)) {}

  Colour exitance(std::size_t triangle) const {
    const double eta = surface_.boundary.eta;
    const Vector3d at = object_.world_from_object * object_.surface.position[triangle];
    const Vector3d normal = object_.world_from_object.rotation * object_.surface.normal[triangle];
    Colour sum = Colour::Zero();
    for (std::size_t s = 0; s < surface_.arriving.size(); ++s) {
      const Colour arriving = surface_.arriving[s][triangle].cast<double>();
      const Eigen::Vector4d& source = answer_.sources[s];
      const Vector3d towards = (source.head<3>() - source.w() * at).normalized();
      const double cosine = std::min(1.0, normal.dot(towards));
      if (cosine <= 0.0 || arriving.maxCoeff() <= 0.0) continue;
      const double inside = std::sqrt(1.0 - (1.0 - cosine * cosine) / (eta * eta));
      const double entering = (1.0 - fresnel_external(eta, cosine)) * cosine / inside;
      const double place = inside * steps;
      const auto i = static_cast<std::size_t>(std::min(place, steps - 1.0));
      const double share = place - static_cast<double>(i);
      sum += arriving * entering * ((1.0 - share) * table_[i] + share * table_[i + 1]);
    }
    return sum * (*surface_.albedo)[triangle];
  }

 private:
  static constexpr int steps = 32;
  const LiveAnswer& answer_;
  const SurfaceLight& surface_;
  const WorldObject& object_;
  const std::vector<double> table_;
};

}  // namespace

LitCorners::LitCorners(const World& world) : world_(world) {
  for (const WorldObject& object : world.objects()) {
    averages_.emplace_back(object.mesh, object.surface);
    corners_ += 3 * object.mesh.triangles.size();
  }
}

std::vector<float> LitCorners::geometry() const {
  std::vector<float> floats;
  floats.reserve(corners_ * geometry_floats);
  for (std::size_t i = 0; i < world_.objects().size(); ++i) {
    const WorldObject& object = world_.objects()[i];
    const auto normals =
        averages_[i].of<Vector3d>(Vector3d::Zero(), [&](std::size_t t) -> Vector3d {
          return object.world_from_object.rotation * object.surface.normal[t];
        });
    for (std::size_t t = 0; t < object.mesh.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto vertex = static_cast<std::size_t>(object.mesh.triangles[t][k]);
        append(object.world_from_object * object.mesh.vertices[vertex], floats);
        append(normals[t][k].normalized(), floats);
        floats.push_back(static_cast<float>(i));
      }
    }
  }
  return floats;
}

std::vector<float> LitCorners::light(const LiveAnswer& answer) const {
  std::vector<float> floats(corners_ * light_floats);
  float* out = floats.data();
  for (std::size_t i = 0; i < world_.objects().size(); ++i) {
    const WorldObject& object = world_.objects()[i];
    const OnceScattered once(answer, i, object);
    const ObjectExitance& of = answer.exitance[i];
    const SurfaceLight& surface = answer.surface[i];
    const BoundaryConstants& boundary = surface.boundary;
    const double transmitted = boundary.eta * boundary.eta * (1.0 - boundary.r_phi);
    using All = Eigen::Array<float, light_floats, 1>;
    std::vector<All> triangles(object.surface.size(), All::Zero());
    for_ranges(triangles.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        const Colour exitance(of.exitance[0][t], of.exitance[1][t], of.exitance[2][t]);
        Colour entering = Colour::Zero();
        if (!of.diffuse[0].empty()) {
          entering = transmitted * Colour(of.diffuse[0][t], of.diffuse[1][t], of.diffuse[2][t]);
        }
        triangles[t].segment<3>(0) = (exitance - entering - once.exitance(t)).cast<float>();
        // What a body emits leaves as what enters diffusely does, refracted alone.
        if (!surface.glow.empty()) {
          entering += std::numbers::pi * (1.0 - boundary.r_phi) * surface.glow[t];
        }
        triangles[t].segment<3>(3) = entering.cast<float>();
        triangles[t].segment<3>(6) = (*surface.albedo)[t].cast<float>();
        for (std::size_t s = 0; s < surface.arriving.size(); ++s) {
          triangles[t].segment<3>(9 + 3 * static_cast<Eigen::Index>(s)) = surface.arriving[s][t];
        }
      }
    });
    const auto corners = averages_[i].of<All>(
        All::Zero(), [&](std::size_t t) -> const All& { return triangles[t]; });
    for (const auto& triangle : corners) {
      for (const All& corner : triangle) out = std::copy(corner.begin(), corner.end(), out);
    }
  }
  return floats;
}

std::vector<float> object_table(const std::vector<SurfaceLight>& surfaces) {
  constexpr std::uint32_t draws = 512;
  std::vector<float> table;
  for (const SurfaceLight& surface : surfaces) {
    const double eta = surface.boundary.eta;
    for (const double value :
         {eta, surface.boundary.A, surface.boundary.r_phi, surface.roughness}) {
      table.push_back(static_cast<float>(value));
    }
    const Ggx ggx(eta, surface.roughness);
    for (int i = 0; i < table_cosines; ++i) {
      const double cosine = std::max(0.02, static_cast<double>(i) / (table_cosines - 1));
      const Vector3d view(std::sqrt(1.0 - cosine * cosine), 0.0, cosine);
      double reflected = ggx.mirror() ? fresnel_external(eta, cosine) : 0.0;
      for (std::uint32_t k = 0; k < draws && !ggx.mirror(); ++k) {
        const auto [u, v] = sobol_point(k, 1);
        const Vector3d light = ggx.sample(view, u, v);
        const double density = ggx.density(view, light);
        if (density > 0.0) reflected += ggx.reflectance(view, light) / density / draws;
      }
      table.insert(table.end(), {static_cast<float>(reflected), 0.0F, 0.0F, 0.0F});
    }
  }
  return table;
}

double usual_exposure(const World& world, const LiveAnswer& answer, const Vector3d& eye) {
  std::vector<double> bright;
  for (std::size_t i = 0; i < world.objects().size(); ++i) {
    const WorldObject& object = world.objects()[i];
    const Vector3d from = object.world_from_object.inverse() * eye;
    const auto& exitance = answer.exitance[i].exitance;
    for (std::size_t t = 0; t < object.surface.size(); ++t) {
      if (object.surface.normal[t].dot(from - object.surface.position[t]) <= 0.0) continue;
      bright.push_back(luminance({exitance[0][t], exitance[1][t], exitance[2][t]}) /
                       std::numbers::pi);
    }
  }
  if (bright.empty()) return 1.0;
  const auto high =
      bright.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(bright.size() - 1));
  std::nth_element(bright.begin(), high, bright.end());
  return *high > 0.0 ? 0.6 / *high : 1.0;
}

}  // namespace kappamu::render
