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
    return sum * surface_.below->albedo[triangle];
  }

 private:
  static constexpr int steps = 32;
  const LiveAnswer& answer_;
  const SurfaceLight& surface_;
  const WorldObject& object_;
  const std::vector<double> table_;
};

std::vector<Colour> once_of(const LiveAnswer& answer, std::size_t index,
                            const WorldObject& object) {
  const OnceScattered once(answer, index, object);
  std::vector<Colour> result(object.surface.size());
  for_ranges(result.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) result[t] = once.exitance(t);
  });
  return result;
}

}  // namespace

LitCorners::LitCorners(const World& world) : world_(world) {
  for (const WorldObject& object : world.objects()) {
    averages_.emplace_back(object.mesh, object.surface);
  }
}

LitCorners::Geometry LitCorners::geometry() {
  Geometry geometry;
  corners_.clear();
  std::size_t before = 0;
  for (std::size_t i = 0; i < world_.objects().size(); ++i) {
    const WorldObject& object = world_.objects()[i];
    const SharedCorners& shared = corners_.emplace_back(averages_[i].shared());
    const auto normals =
        averages_[i].of<Vector3d>(shared, Vector3d::Zero(), [&](std::size_t t) -> Vector3d {
          return object.world_from_object.rotation * object.surface.normal[t];
        });
    for (std::size_t c = 0; c < shared.first.size(); ++c) {
      const std::size_t corner = shared.first[c];
      const auto vertex = static_cast<std::size_t>(object.mesh.triangles[corner / 3][corner % 3]);
      append(object.world_from_object * object.mesh.vertices[vertex], geometry.corners);
      append(normals[c].normalized(), geometry.corners);
      geometry.corners.push_back(static_cast<float>(i));
    }
    for (std::array<std::uint32_t, 3> of_triangle : shared.of_triangle) {
      for (std::uint32_t& corner : of_triangle) corner += static_cast<std::uint32_t>(before);
      geometry.triangles.push_back(of_triangle);
    }
    before += shared.first.size();
  }
  return geometry;
}

template <int sources>
std::vector<float> LitCorners::light_of(const LiveAnswer& answer) const {
  using All = Eigen::Array<float, light_floats(sources), 1>;
  std::vector<float> floats;
  std::size_t corners = 0;
  for (const SharedCorners& shared : corners_) corners += shared.first.size();
  floats.reserve(corners * light_floats(sources));
  for (std::size_t i = 0; i < world_.objects().size(); ++i) {
    const WorldObject& object = world_.objects()[i];
    const std::vector<Colour> once = once_of(answer, i, object);
    const ObjectExitance& of = answer.exitance[i];
    const SurfaceLight& surface = answer.surface[i];
    const BoundaryConstants& boundary = surface.boundary;
    const double transmitted = boundary.eta * boundary.eta * (1.0 - boundary.r_phi);
    std::vector<All> triangles(object.surface.size());
    for_ranges(triangles.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        const Colour exitance(of.exitance[0][t], of.exitance[1][t], of.exitance[2][t]);
        Colour entering = Colour::Zero();
        if (!of.diffuse[0].empty()) {
          entering = transmitted * Colour(of.diffuse[0][t], of.diffuse[1][t], of.diffuse[2][t]);
        }
        triangles[t].template segment<3>(0) =
            (exitance - entering - once[t]).template cast<float>();
        // What a body emits leaves as what enters diffusely does, refracted alone.
        if (!surface.below->glow.empty()) {
          entering += std::numbers::pi * (1.0 - boundary.r_phi) * surface.below->glow[t];
        }
        triangles[t].template segment<3>(3) = entering.template cast<float>();
        triangles[t].template segment<3>(6) = surface.below->albedo[t].template cast<float>();
        for (std::size_t s = 0; s < static_cast<std::size_t>(sources); ++s) {
          triangles[t].template segment<3>(9 + 3 * static_cast<Eigen::Index>(s)) =
              surface.arriving[s][t];
        }
      }
    });
    const auto of_corners = averages_[i].template of<All>(
        corners_[i], All::Zero(), [&](std::size_t t) -> const All& { return triangles[t]; });
    for (const All& corner : of_corners) floats.insert(floats.end(), corner.begin(), corner.end());
  }
  return floats;
}

std::vector<float> LitCorners::light(const LiveAnswer& answer) const {
  static_assert(most_drawn_sources == 4);
  switch (answer.sources.size()) {
    case 0:
      return light_of<0>(answer);
    case 1:
      return light_of<1>(answer);
    case 2:
      return light_of<2>(answer);
    case 3:
      return light_of<3>(answer);
    default:
      return light_of<4>(answer);
  }
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
