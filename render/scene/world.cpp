#include "render/scene/world.h"

#include <algorithm>
#include <numbers>

#include "core/error.h"
#include "core/process_memory.h"
#include "io/polycube_file.h"
#include "render/scene/edited_object.h"
#include "render/scene/measured_reflectance.h"
#include "render/scene/object_shape.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

TriangleMesh deformed_mesh(const SceneObject& object, const TriangleMesh& rest,
                           std::vector<std::string>& warnings) {
  const auto* volume = std::get_if<VolumeMaterial>(&object.material);
  if (!object.deform.empty() && volume && volume->placement != VolumeMaterial::Placement::shell) {
    warnings.push_back("object '" + object.name +
                       "': its volume stays where it lies in the undeformed shape");
  }
  try {
    return deformed_body(rest, object.deform);
  } catch (const InputError& error) {
    throw InputError("object '" + object.name + "': " + error.what());
  }
}

WorldObject make_shape(const SceneObject& object, std::vector<std::string>& warnings) {
  WorldObject made;
  made.name = object.name;
  made.rest = make_object_mesh(object, warnings);
  made.mesh = deformed_mesh(object, made.rest, warnings);
  made.surface = surface_of(made.mesh);
  made.world_from_object = {turn_matrix(object.turn_deg), object.position_mm};
  made.rays = make_embree_caster(made.mesh);
  if (object.polycube) made.polycube = io::read_polycube(*object.polycube);
  made.emission = object.emission;
  return made;
}

ObjectMedia media_in(const WorldObject& made, const SceneObject& object,
                     std::vector<std::string>& warnings) {
  if (object.edits) {
    const EditedObject edited(object, made.rest, made.mesh, *made.rays);
    warnings.insert(warnings.end(), edited.warnings().begin(), edited.warnings().end());
    return edited.media();
  }
  ObjectMedia media = make_object_media(object, made.rest, made.mesh, warnings);
  if (object.finish.eta) media.eta = object.finish.eta;
  media.roughness = object.finish.roughness;
  return media;
}

void make_material(const SceneObject& object, WorldObject& made,
                   std::vector<std::string>& warnings) {
  made.media = media_in(made, object, warnings);
  made.boundary = boundary_constants(made.media.eta.value_or(1.3));
  made.roughness = *made.media.roughness;
  if (!object.finish.detail.any()) return;
  try {
    made.maps = std::make_shared<const SurfaceMaps>(
        object.finish.detail, made.mesh,
        object.finish.detail.reflectance_measured
            ? measured_reflectance(object.material, made.rest, made.mesh)
            : nullptr);
  } catch (const InputError& error) {
    throw InputError("object '" + object.name + "': " + error.what());
  }
}

}  // namespace

namespace {

/// Of meshes, samples, both casters and what pictures keep of corners.
constexpr double bytes_per_triangle = 1000.0;

void expect_memory(std::size_t triangles, const std::string& object) {
  const double bytes = bytes_per_triangle * static_cast<double>(triangles);
  if (bytes <= usable_memory()) return;
  throw InputError("object '" + object + "': with it the scene has " + std::to_string(triangles) +
                   " triangles, which need " + gigabytes(bytes) +
                   " of memory where this machine has " + gigabytes(main_memory()) +
                   "; leave objects out or decimate their meshes");
}

}  // namespace

World::World(const Scene& scene, std::vector<std::string>& warnings,
             const ShapesKnown& shapes_known) {
  TriangleMesh all;
  for (const SceneObject& object : scene.objects) {
    objects_.push_back(make_shape(object, warnings));
    const WorldObject& made = objects_.back();
    first_triangle_.push_back(all.triangles.size());
    expect_memory(all.triangles.size() + made.mesh.triangles.size(), object.name);
    const int first = static_cast<int>(all.vertices.size());
    for (const Vector3d& vertex : made.mesh.vertices) {
      all.vertices.push_back(made.world_from_object * vertex);
    }
    for (const auto& [a, b, c] : made.mesh.triangles) {
      all.triangles.push_back({first + a, first + b, first + c});
    }
  }
  diameter_ = bounding_box(all).diagonal().norm();
  skin_ = 1e-6 * diameter_;
  rays_ = make_embree_caster(all);
  vertices_ = std::move(all.vertices);
  triangles_ = std::move(all.triangles);

  expect_apart();
  expect_outside(scene.camera.position_mm, "the camera");
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const std::string name = "light " + std::to_string(i + 1);
    if (const auto* spot = std::get_if<SpotLight>(&scene.lights[i])) {
      expect_outside(spot->point.position_mm, name);
    } else if (const auto* projector = std::get_if<ProjectorLight>(&scene.lights[i])) {
      expect_outside(projector->point.position_mm, name);
    }
  }
  set_lights(scene.lights);
  shapes_known(*this);
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    make_material(scene.objects[i], objects_[i], warnings);
  }
}

void World::set_lights(const std::vector<Light>& lights) {
  inner_lights_.clear();
  outer_lights_.clear();
  for (const Light& light : lights) {
    const auto* point = std::get_if<PointLight>(&light);
    if (const auto object = point ? object_at(point->position_mm) : std::nullopt) {
      const double sphere = 4.0 * std::numbers::pi * point->at_mm * point->at_mm;
      inner_lights_.push_back({*object, point->position_mm, sphere * point->irradiance});
    } else {
      outer_lights_.push_back(light);
    }
  }
}

bool World::lit_inside() const {
  return !inner_lights_.empty() ||
         std::any_of(objects_.begin(), objects_.end(),
                     [](const WorldObject& object) { return object.emission.maxCoeff() > 0.0; });
}

void World::set_media(std::size_t object, ObjectMedia media) {
  WorldObject& set = objects_[object];
  set.media = std::move(media);
  const double eta = set.media.eta.value_or(set.boundary.eta);
  if (eta != set.boundary.eta) set.boundary = boundary_constants(eta);
  set.roughness = set.media.roughness.value_or(set.roughness);
}

void World::move(std::size_t object, std::vector<Vector3d> vertices) {
  WorldObject& moved = objects_[object];
  check(vertices.size() == moved.mesh.vertices.size(), "moved vertices are as many as before");
  moved.mesh.vertices = std::move(vertices);
  moved.surface = surface_of(moved.mesh);
  moved.rays->move(moved.mesh.vertices);
  auto at = vertices_.begin();
  for (std::size_t i = 0; i < object; ++i) {
    at += static_cast<std::ptrdiff_t>(objects_[i].mesh.vertices.size());
  }
  for (const Vector3d& vertex : moved.mesh.vertices) *at++ = moved.world_from_object * vertex;
  rays_->move(vertices_);
}

World::World(const World& other)
    : inner_lights_(other.inner_lights_),
      outer_lights_(other.outer_lights_),
      first_triangle_(other.first_triangle_),
      triangles_(other.triangles_),
      vertices_(other.vertices_),
      skin_(other.skin_),
      diameter_(other.diameter_) {
  for (const WorldObject& object : other.objects_) objects_.push_back(object.copy());
  rays_ = make_embree_caster({vertices_, triangles_, {}});
}

WorldObject WorldObject::copy() const {
  return {
      name,     rest,     mesh,      surface, world_from_object, make_embree_caster(mesh), media,
      polycube, boundary, roughness, maps,    emission};
}

std::optional<WorldHit> World::first_hit(const Vector3d& origin, const Vector3d& direction,
                                         double nearest, double farthest) const {
  const auto met = rays_->first_hit(origin, direction, nearest, farthest);
  if (!met) return std::nullopt;
  const auto triangle = static_cast<std::size_t>(met->triangle);
  const auto after = std::upper_bound(first_triangle_.begin(), first_triangle_.end(), triangle);
  WorldHit hit;
  hit.object = static_cast<std::size_t>(after - first_triangle_.begin()) - 1;
  hit.triangle = triangle - first_triangle_[hit.object];
  hit.distance = met->distance;
  hit.u = met->u;
  hit.v = met->v;
  hit.position = origin + met->distance * direction;
  const WorldObject& object = objects_[hit.object];
  hit.normal = object.world_from_object.rotation * object.surface.normal[hit.triangle];
  return hit;
}

std::optional<std::size_t> World::object_at(const Vector3d& point) const {
  // From inside, a ray first meets a surface from behind. Any direction would do but for edges.
  const Vector3d direction = Vector3d(0.5377, 0.8339, -0.1241).normalized();
  const auto hit = first_hit(point, direction, 0.0);
  if (!hit || hit->normal.dot(direction) <= 0.0) return std::nullopt;
  return hit->object;
}

void World::expect_apart() const {
  for (std::size_t one = 0; one < objects_.size(); ++one) {
    for (std::size_t other = 0; other < objects_.size(); ++other) {
      if (one == other) continue;
      const Rigid one_from_other =
          objects_[one].world_from_object.inverse() * objects_[other].world_from_object;
      const Eigen::AlignedBox3d box = bounding_box(objects_[one].mesh);
      for (const Vector3d& vertex : objects_[other].mesh.vertices) {
        const Vector3d point = one_from_other * vertex;
        if (!box.contains(point)) continue;
        const Vector3d up = Vector3d(0.1241, 0.8339, 0.5377).normalized();
        const auto hit = objects_[one].rays->first_hit(point, up, skin_);
        if (hit &&
            objects_[one].surface.normal[static_cast<std::size_t>(hit->triangle)].dot(up) > 0.0) {
          throw InputError("objects '" + objects_[one].name + "' and '" + objects_[other].name +
                           "' overlap; change the position_mm of one of the two");
        }
      }
    }
  }
}

void World::expect_outside(const Vector3d& point, const std::string& what) const {
  if (const auto object = object_at(point)) {
    throw InputError(what + " is inside object '" + objects_[*object].name +
                     "'; change its position_mm, or give the mesh a void around it");
  }
}

}  // namespace kappamu::render
