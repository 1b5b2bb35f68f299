#include "forward/light/beam_path.h"

#include <algorithm>
#include <string>

#include "core/error.h"
#include "core/optics.h"

namespace kappamu::forward {

namespace {

/// In a medium that is almost clear light goes round by total reflection; what is left then leaves.
constexpr std::size_t most_chords = 1000;
/// Outside: of a beam, what is followed no further.
constexpr double followed_to = 1e-6;

}  // namespace

BeamPath::BeamPath(const Walls& walls, const Beam& beam) : enters_(beam.triangle) {
  const Eigen::Vector3d& normal = walls.normal(beam.triangle);
  const double cosine = -beam.direction.dot(normal);
  if (begins_inside(beam, normal)) {
    const auto hit = walls.ahead(beam.position, beam.direction);
    if (hit && hit->triangle == beam.triangle) {
      transmitted_ = 1.0;
      from_inside_ = true;
      add_chord(walls, beam.position, beam.direction, *hit);
      return;
    }
  }
  if (!(cosine > 0.0)) {
    throw InputError("a beam meets triangle " + std::to_string(beam.triangle) +
                     " from inside the object; lights must lie outside it");
  }
  transmitted_ = 1.0 - fresnel_external(walls.eta(), std::min(1.0, cosine));
  go_on(walls, beam.position, refracted(beam.direction, normal, 1.0 / walls.eta()), beam.triangle);
}

void BeamPath::go_on(const Walls& walls, Eigen::Vector3d from, const Eigen::Vector3d& direction,
                     int triangle) {
  const std::optional<RayHit> hit = walls.inside(from, direction, triangle);
  if (hit) add_chord(walls, from, direction, *hit);
}

void BeamPath::add_chord(const Walls& walls, const Eigen::Vector3d& from,
                         const Eigen::Vector3d& direction, const RayHit& hit) {
  const double cosine = std::min(1.0, walls.normal(hit.triangle).dot(direction));
  chords_.push_back(
      {from, direction, hit.distance, hit.triangle, walls.transmitted(hit.triangle, cosine)});
}

const Chord* BeamPath::chord(std::size_t k, const Walls& walls) {
  if (k > 0 && k == chords_.size() && k < most_chords) {
    const Chord& last = chords_.back();
    if (last.leaves < 1.0) {
      go_on(walls, last.from + last.length * last.direction,
            mirrored(last.direction, walls.normal(last.meets)), last.meets);
    }
  }
  return k < chords_.size() ? &chords_[k] : nullptr;
}

Beam leaving(const Walls& walls, const Chord& chord, double power) {
  return {chord.meets, chord.from + chord.length * chord.direction,
          refracted(chord.direction, -walls.normal(chord.meets), walls.eta()), power};
}

double meet_again(const MeshWalls& walls, Beam beam, std::vector<Beam>& beams) {
  const double left = beam.power, least = followed_to * left;
  bool met = false;
  while (beam.power > least) {
    const std::optional<RayHit> hit = walls.outside(beam.position, beam.direction, beam.triangle);
    if (!hit) break;
    met = true;
    beam.triangle = hit->triangle;
    beam.position += hit->distance * beam.direction;
    beams.push_back(beam);
    const Eigen::Vector3d& normal = walls.normal(beam.triangle);
    beam.power *= fresnel_external(walls.eta(), std::min(1.0, -normal.dot(beam.direction)));
    beam.direction = mirrored(beam.direction, normal);
  }
  return met ? left : 0.0;
}

}  // namespace kappamu::forward
