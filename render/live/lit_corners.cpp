#include "render/live/lit_corners.h"

#include <algorithm>
#include <numbers>

namespace kappamu::render {

using Eigen::Vector3d;

namespace {

template <class Value>
void append(const Value& value, std::vector<float>& out) {
  for (Eigen::Index i = 0; i < 3; ++i) out.push_back(static_cast<float>(value[i]));
}

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
    const Vector3d boundary(object.boundary.eta, object.boundary.A, object.boundary.r_phi);
    for (std::size_t t = 0; t < object.mesh.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto vertex = static_cast<std::size_t>(object.mesh.triangles[t][k]);
        append(object.world_from_object * object.mesh.vertices[vertex], floats);
        append(normals[t][k].normalized(), floats);
        append(boundary, floats);
      }
    }
  }
  return floats;
}

std::vector<float> LitCorners::light(const LiveAnswer& answer) const {
  std::vector<float> floats;
  floats.reserve(corners_ * light_floats);
  for (std::size_t i = 0; i < world_.objects().size(); ++i) {
    const ObjectExitance& of = answer.exitance[i];
    const BoundaryConstants& boundary = world_.objects()[i].boundary;
    const double transmitted = boundary.eta * boundary.eta * (1.0 - boundary.r_phi);
    using Both = Eigen::Array<double, light_floats, 1>;
    const auto corners = averages_[i].of<Both>(Both::Zero(), [&](std::size_t t) -> Both {
      Both both = Both::Zero();
      for (std::size_t c = 0; c < 3; ++c) {
        const auto at = static_cast<Eigen::Index>(c);
        if (!of.diffuse[c].empty()) both[3 + at] = transmitted * of.diffuse[c][t];
        both[at] = of.exitance[c][t] - both[3 + at];
      }
      return both;
    });
    for (const auto& triangle : corners) {
      for (const Both& corner : triangle) {
        for (const double value : corner) floats.push_back(static_cast<float>(value));
      }
    }
  }
  return floats;
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
