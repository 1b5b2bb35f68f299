#include "app/viewer/fur/fur_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/error.h"
#include "core/processor_time.h"
#include "render/light/environment.h"
#include "render/light/light_source.h"

namespace kappamu::app {

using Eigen::Vector3d;

namespace {

/// Rays of the first tile, which takes a sixteenth of the usual time.
constexpr int first_rays = 64;

}  // namespace

struct FurModel::Coat {
  struct MadeTile {
    std::shared_ptr<const render::FurTile> tile;
    render::FurVolume volume;
    double seconds = 0.0;
  };
  Shown shown;
  std::optional<render::CoatPainter> painter;
  std::size_t finished = 0;  ///< strokes that are edits
  std::unique_ptr<render::FurryObject> furry;
  std::future<MadeTile> coming;
  render::Fur asked;  ///< of the tile that comes or is shown
  int rays = 0;       ///< of that
  bool placed = false, lit = false;
};

FurModel::FurModel(const render::Scene& scene, const render::World& world)
    : world_(world), lights_(scene.lights) {
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (!scene.objects[i].fur) continue;
    auto coat = std::make_unique<Coat>();
    coat->shown.object = i;
    coat->shown.fur = coat->asked = *scene.objects[i].fur;
    coat->painter.emplace(world.objects()[i].rest, coat->shown.fur);
    coat->finished = coat->shown.fur.strokes.size();
    begin_tile(*coat, std::min(first_rays, coat->shown.fur.rays));
    coats_.push_back(std::move(coat));
  }
}

FurModel::~FurModel() = default;

const FurModel::Shown& FurModel::shown(std::size_t coat) const {
  return coats_[coat]->shown;
}

const std::string& FurModel::name(std::size_t coat) const {
  return world_.objects()[coats_[coat]->shown.object].name;
}

bool FurModel::making(std::size_t coat) const {
  return coats_[coat]->coming.valid();
}

bool FurModel::making() const {
  return std::any_of(coats_.begin(), coats_.end(),
                     [](const auto& coat) { return coat->coming.valid(); });
}

void FurModel::shade(render::LiveAnswer& answer) const {
  for (const auto& coat : coats_) {
    const std::size_t object = coat->shown.object;
    const auto& triangles = world_.objects()[object].mesh.triangles;
    const std::vector<double>& shares = coat->shown.skin_shares;
    if (shares.empty()) continue;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      double share = 0.0;
      for (const int v : triangles[t]) share += shares[static_cast<std::size_t>(v)] / 3.0;
      for (std::size_t c = 0; c < 3; ++c) {
        answer.exitance[object].exitance[c][t] *= share;
        if (!answer.exitance[object].diffuse[c].empty()) {
          answer.exitance[object].diffuse[c][t] *= share;
        }
      }
      for (auto& source : answer.surface[object].arriving) {
        source[t] *= static_cast<float>(share);
      }
    }
  }
}

void FurModel::begin_tile(Coat& coat, int rays) const {
  coat.asked = coat.shown.fur;
  coat.rays = rays;
  render::Fur fur = coat.asked;
  fur.rays = rays;
  coat.coming = std::async(std::launch::async, [fur] {
    const Stopwatch watch;
    Progress progress;
    Coat::MadeTile made;
    made.tile = std::make_shared<const render::FurTile>(render::make_fur_tile(fur, progress));
    made.volume = render::make_fur_volume(*made.tile);
    made.seconds = watch.seconds();
    return made;
  });
}

void FurModel::set(std::size_t index, const render::Fur& fur) {
  Coat& coat = *coats_[index];
  render::require_tile(world_.objects()[coat.shown.object].mesh, fur.tile());
  const render::Fur before = std::exchange(coat.shown.fur, fur);
  coat.finished = fur.strokes.size();
  const bool same_strokes =
      std::equal(before.strokes.begin(), before.strokes.end(), fur.strokes.begin(),
                 fur.strokes.end(), [](const render::FurStroke& a, const render::FurStroke& b) {
                   return a.same_brush(b) && a.points_mm == b.points_mm;
                 });
  if (before.length_mm != fur.length_mm || before.tile() != fur.tile() || before.comb != fur.comb ||
      before.comb_turn_deg != fur.comb_turn_deg || !same_strokes) {
    coat.placed = false;
  }
}

void FurModel::follow(const std::function<render::Fur(std::size_t)>& fur_of) {
  for (std::size_t i = 0; i < coats_.size(); ++i) {
    try {
      set(i, fur_of(coats_[i]->shown.object));
    } catch (const InputError& error) {
      coats_[i]->shown.fault = error.what();
    }
  }
}

void FurModel::set_lights(const std::vector<render::Light>& lights) {
  lights_ = lights;
  for (const auto& coat : coats_) coat->lit = false;
}

void FurModel::moved() {
  for (const auto& coat : coats_) coat->placed = false;
}

std::optional<FurModel::At> FurModel::at(const render::LookAt& look,
                                         const Eigen::Vector2d& place) const {
  const auto hit = world_.first_hit(look.position(), look.direction(place.x(), place.y()), 0.0);
  if (!hit) return std::nullopt;
  const TriangleMesh& rest = world_.objects()[hit->object].rest;
  const auto& [a, b, c] = rest.triangles[hit->triangle];
  const auto corner = [&](int v) { return rest.vertices[static_cast<std::size_t>(v)]; };
  return At{hit->object, Vector3d((1.0 - hit->u - hit->v) * corner(a) + hit->u * corner(b) +
                                  hit->v * corner(c))};
}

bool FurModel::stroke(const render::LookAt& look, const Eigen::Vector2d& from,
                      const Eigen::Vector2d& to) {
  const std::optional<At> start = at(look, from), end = at(look, to);
  if (!start || !end || start->object != end->object) return false;
  const auto found = std::find_if(coats_.begin(), coats_.end(), [&](const auto& coat) {
    return coat->shown.object == start->object;
  });
  if (found == coats_.end() || !(*found)->furry) return false;
  std::vector<render::FurStroke>& strokes = (*found)->shown.fur.strokes;
  const bool begun = strokes.size() > (*found)->finished;
  if (!begun || !strokes.back().same_brush(brush) ||
      strokes.back().points_mm.back() != start->point_mm) {
    strokes.push_back(brush);
    strokes.back().points_mm = {start->point_mm};
  }
  strokes.back().points_mm.push_back(end->point_mm);
  (*found)->placed = false;
  return true;
}

std::map<std::size_t, render::FurChange> FurModel::end_stroke() {
  std::map<std::size_t, render::FurChange> changes;
  for (const auto& coat : coats_) {
    const std::vector<render::FurStroke>& strokes = coat->shown.fur.strokes;
    if (strokes.size() <= coat->finished) continue;
    changes[coat->shown.object].strokes.assign(
        strokes.begin() + static_cast<std::ptrdiff_t>(coat->finished), strokes.end());
    coat->finished = strokes.size();
  }
  return changes;
}

bool FurModel::update() {
  bool changed = false;
  for (const auto& held : coats_) {
    Coat& coat = *held;
    Shown& shown = coat.shown;
    if (coat.coming.valid() &&
        coat.coming.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
      Coat::MadeTile made = coat.coming.get();
      shown.tile = std::move(made.tile);
      shown.volume = std::move(made.volume);
      shown.tile_s = made.seconds;
      ++shown.volume_version;
      coat.placed = false;
    }
    if (!coat.coming.valid()) {
      if (!render::same_tile(coat.asked, shown.fur)) {
        begin_tile(coat, std::min(first_rays, shown.fur.rays));
      } else if (coat.rays < shown.fur.rays) {
        begin_tile(coat, shown.fur.rays);
      }
    }
    if (!shown.tile) continue;
    if (!coat.placed) {
      const Stopwatch watch;
      const render::WorldObject& object = world_.objects()[shown.object];
      try {
        coat.furry = std::make_unique<render::FurryObject>(object, shown.fur, shown.tile,
                                                           coat.painter->of(shown.fur));
        shown.fault.clear();
      } catch (const InputError& error) {  // a shape that has moved
        if (!coat.furry) throw;
        shown.fault = error.what();
        coat.placed = true;
        continue;
      }
      shown.corners.geometry = render::fur_geometry(*coat.furry);
      shown.patches = coat.furry->placement().patches();
      shown.stretch = coat.furry->placement().stretch();
      shown.place_ms = watch.milliseconds();
      ++shown.geometry_version;
      coat.placed = true;
      coat.lit = false;
      changed = true;
    }
    if (!coat.lit) {
      const Stopwatch watch;
      const auto environment = render::make_environment(lights_);
      coat.furry->set_light(world_, render::make_light_sources(lights_),
                            environment ? &*environment : nullptr);
      render::light_fur(*coat.furry, shown.volume, shown.corners);
      shown.skin_shares = render::skin_shares(*coat.furry);
      shown.light_ms = watch.milliseconds();
      ++shown.light_version;
      coat.lit = changed = true;
    }
  }
  return changed;
}

void FurModel::finish() {
  for (bool open = true; open;) {
    update();
    open = false;
    for (const auto& coat : coats_) {
      if (!coat->coming.valid()) continue;
      coat->coming.wait();
      open = true;
    }
  }
}

}  // namespace kappamu::app
