// Beams inside objects: Snell's and Fresnel's laws at every surface, and the walk of photons, which
// knows nothing of the march.
#include "forward/light/beam_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/shapes.h"
#include "core/optics.h"
#include "forward/registry.h"
#include "tests/forward/lit_object.h"

namespace kappamu::forward {
namespace {

using Eigen::Vector3d;

constexpr double eta = 1.3;

ObjectResult solved(const LitObject& object, const std::string& model, const ObjectOptions& options,
                    double photons = 2e4) {
  Progress silent;
  return make_walking(model, photons)->solve(object.problem(), options, silent);
}

/// κ from σs' and σa [1/mm].
Coefficients medium(double scattering, double absorption) {
  return {1.0 / (3.0 * (scattering + absorption)), absorption};
}

const Vector3d aslant = Vector3d(-0.5, -0.7, -0.5).normalized();

LitObject lit(const std::string& shape, double size, const Coefficients& filling) {
  LitObject object(make_shape(shape, size, 12), ObjectMedium(filling));
  object.lights = {parallel_beams(object.surface, aslant)};
  return object;
}

// Through a cube's upper face, aslant: the sides reflect it totally, and it comes to the lower
// face, to the upper one and so on, as steep as at first.
TEST(BeamPath, IsReflectedToAndFroInACube) {
  const LitObject cube(make_shape("cube", 2.0, 1), ObjectMedium(medium(1.0, 0.0)));
  const Walls walls(cube.problem());
  for (const Beam& beam : parallel_beams(cube.surface, aslant).beams) {
    BeamPath path(walls, beam);
    const double arrives = -walls.normal(beam.triangle).dot(aslant);
    EXPECT_NEAR(path.transmitted(), 1.0 - fresnel_external(eta, arrives), 1e-12);
    const Vector3d first = path.chord(0, walls)->direction;
    for (std::size_t k = 0; k < 30; ++k) {
      const Chord* chord = path.chord(k, walls);
      ASSERT_NE(chord, nullptr);
      // Mirrors along the axes turn signs alone.
      EXPECT_LT((chord->direction.cwiseAbs() - first.cwiseAbs()).norm(), 1e-9);
      const double cosine = walls.normal(chord->meets).dot(chord->direction);
      EXPECT_NEAR(chord->leaves, 1.0 - fresnel_internal(eta, cosine), 1e-9);
    }
  }
}

TEST(BeamPath, LeavesByTheLawOfRefraction) {
  const LitObject cube(make_shape("cube", 2.0, 1), ObjectMedium(medium(1.0, 0.0)));
  const Walls walls(cube.problem());
  for (const Beam& beam : parallel_beams(cube.surface, aslant).beams) {
    BeamPath path(walls, beam);
    for (std::size_t k = 0; k < 10; ++k) {
      const Chord& chord = *path.chord(k, walls);
      if (chord.leaves == 0.0) continue;
      const Beam out = leaving(walls, chord, 1.0);
      // Parallel faces: as steep to the face's normal as it came.
      EXPECT_NEAR(walls.normal(chord.meets).dot(out.direction),
                  std::abs(walls.normal(chord.meets).dot(aslant)), 1e-9);
      std::vector<Beam> again;
      EXPECT_EQ(meet_again(walls, out, again), 0.0) << "a cube does not meet itself";
    }
  }
}

struct Body {
  std::string shape;
  double size;  ///< [mm]
};

// Within a percent of what enters, and noise. The ray caster of these tests loses some rays along
// edges, which then count as unscattered.
TEST(BeamMarch, DividesPowerAsTheWalkOfPhotonsDoes) {
  constexpr double sigmas = 4.0, of_entering = 0.01;
  for (const Body& body : {Body{"cube", 12.0}, Body{"torus", 30.0}}) {
    const LitObject object = lit(body.shape, body.size, medium(0.79, 0.01));
    ObjectOptions options;
    constexpr double photons = 2e4;
    const ObjectBalance walk = solved(object, "montecarlo", options, photons).balance[0];
    const double passes = walk.unscattered / walk.entering;
    const double noise = sigmas * std::sqrt(passes * (1.0 - passes) / photons);
    options.tolerance = 0.05;
    for (const char* model : {"embedded", "polygrid"}) {
      const std::string name = std::string(model) + " " + body.shape;
      const ObjectBalance mine = solved(object, model, options).balance[0];
      EXPECT_NEAR(mine.entering, walk.entering, 1e-9 * walk.entering) << name;
      EXPECT_NEAR(mine.unscattered, walk.unscattered, (of_entering + noise) * walk.entering)
          << name;
      EXPECT_NEAR(mine.exiting, walk.exiting, (of_entering + noise) * walk.entering) << name;
      EXPECT_NEAR(mine.unscattered + mine.exiting + mine.absorbed, mine.entering,
                  1e-6 * mine.entering)
          << name;
    }
  }
}

// Thin enough for a third to pass: what passes one part of a ring meets another one.
TEST(BeamMarch, ComesInAgainAsPhotonsDo) {
  constexpr double sigmas = 4.0;
  LitObject ring = lit("torus", 10.0, medium(0.4, 0.01));
  ring.lights = {parallel_beams(ring.surface, Vector3d(-1.0, -0.2, -0.1).normalized())};
  ObjectOptions options;
  constexpr double photons = 2e5;
  options.tolerance = 0.05;
  const ObjectOptions plain = options;
  options.follow_reentry = true;
  const ObjectBalance walk = solved(ring, "montecarlo", options, photons).balance[0];
  const ObjectBalance mine = solved(ring, "embedded", options).balance[0];
  const double once = solved(ring, "embedded", plain).balance[0].unscattered;
  // Of what leaves again, photons count each time: at most twice as noisy as shares of one.
  const double noise = 2.0 * sigmas * walk.entering * 0.5 / std::sqrt(photons);
  EXPECT_GT(std::abs(walk.unscattered - once), noise);
  EXPECT_NEAR(mine.unscattered, walk.unscattered, noise);
  EXPECT_NEAR(mine.reentering, walk.reentering, noise + 0.02 * walk.entering);
  EXPECT_NEAR(mine.unscattered + mine.exiting + mine.absorbed, mine.entering, 1e-6 * mine.entering);
}

}  // namespace
}  // namespace kappamu::forward
