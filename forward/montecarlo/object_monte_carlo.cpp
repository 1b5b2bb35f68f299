#include "forward/montecarlo/object_monte_carlo.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <string>

#include "core/error.h"
#include "core/optics.h"
#include "core/parallel.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "forward/light/beam_path.h"
#include "forward/light_entry.h"
#include "forward/montecarlo/object_walk.h"
#include "forward/montecarlo/photon_tables.h"
#include "forward/montecarlo/photon_tracer.h"
#include "forward/patches.h"

namespace kappamu::forward {

namespace {

using Eigen::Vector3d;

/// Above this the fictitious collisions cost more than all else.
constexpr double slow_tentative_ratio = 20.0;
/// Of the light, lost by rounding at edges: more than this is worth a warning.
constexpr double most_slipped = 1e-3;
constexpr double seconds_per_update = 1.0;

/// Where the photons of one light enter: its beams, then its surface samples.
class Entry {
 public:
  Entry(const ObjectProblem& problem, const WalkScene& scene, const ObjectLight& light)
      : problem_(problem), scene_(scene), light_(light) {
    for (const Beam& beam : light.beams) {
      const Vector3d& normal = problem.surface.normal[static_cast<std::size_t>(beam.triangle)];
      const double cosine = std::min(1.0, -beam.direction.dot(normal));
      const double reflected =
          begins_inside(beam, normal) ? 0.0 : fresnel_external(problem.eta, cosine);
      power_.push_back(beam.power * (1.0 - reflected));
    }
    const double diffuse =
        problem.eta * problem.eta * (1.0 - boundary_constants(problem.eta).r_phi);
    for (std::size_t i = 0; i < light.diffuse.size(); ++i) {
      power_.push_back(diffuse * light.diffuse[i] * problem.surface.area[i]);
    }
    for (const double power : power_) total_ += power;
    if (total_ > 0.0) aliases_ = alias_table(power_);
  }

  double power() const { return total_; }  ///< that enters [mm²]

  WalkStart start(PhotonWalk& walk) const {
    const PhiloxBlock r = walk.draw();
    auto chosen = static_cast<std::size_t>((std::uint64_t{r[0]} * aliases_.size()) >> 32);
    if (r[1] >= aliases_[chosen].keep) chosen = aliases_[chosen].other;
    WalkStart start;
    if (chosen < light_.beams.size()) {
      const Beam& beam = light_.beams[chosen];
      start.triangle = beam.triangle;
      if (begins_inside(beam, problem_.surface.normal[static_cast<std::size_t>(beam.triangle)])) {
        start.inside = true;
        start.position = beam.position;
        start.direction = beam.direction;
        return start;
      }
      start.position = scene_.walls.nudged(beam.position, beam.triangle);  // it may lie on an edge
      start.direction = refracted(beam.direction,
                                  problem_.surface.normal[static_cast<std::size_t>(beam.triangle)],
                                  1.0 / problem_.eta);
      return start;
    }
    const std::size_t t = chosen - light_.beams.size();
    const auto corner = [&](std::size_t k) -> const Vector3d& {
      return problem_.mesh.vertices[static_cast<std::size_t>(problem_.mesh.triangles[t][k])];
    };
    const Vector3d& normal = problem_.surface.normal[t];
    const double root = std::sqrt(uniform_of(r[2])), along = uniform_of(r[3]);
    start.triangle = static_cast<int>(t);
    start.position = corner(0) + root * ((1.0 - along) * (corner(1) - corner(0)) +
                                         along * (corner(2) - corner(0)));
    start.direction = refracted(diffuse_direction(normal, walk), normal, 1.0 / problem_.eta);
    start.scattered = true;
    return start;
  }

 private:
  /// From outside, of light that is diffuse there: what enters, which is less at grazing angles.
  Vector3d diffuse_direction(const Vector3d& normal, PhotonWalk& walk) const {
    while (true) {
      const PhiloxBlock r = walk.draw();
      const double cosine = std::sqrt(uniform_of(r[0])), sine = std::sqrt(1.0 - cosine * cosine);
      if (uniform_of(r[2]) < fresnel_external(problem_.eta, cosine)) continue;
      const double turn = 2.0 * EIGEN_PI * uniform_of(r[1]);
      const Vector3d aside = normal.unitOrthogonal();
      return sine * (std::cos(turn) * aside + std::sin(turn) * normal.cross(aside)) -
             cosine * normal;
    }
  }

  const ObjectProblem& problem_;
  const WalkScene& scene_;
  const ObjectLight& light_;
  std::vector<double> power_;
  double total_ = 0.0;
  std::vector<AliasEntry> aliases_;
};

void add(std::uint64_t& tally, std::uint64_t amount) {
  std::atomic_ref(tally).fetch_add(amount, std::memory_order_relaxed);
}

/// A photon that leaves one sample several times scores there once, with the sum.
void score(std::vector<Exit>& exits, std::vector<Score>& scores) {
  std::sort(exits.begin(), exits.end(),
            [](const Exit& a, const Exit& b) { return a.triangle < b.triangle; });
  for (std::size_t i = 0; i < exits.size();) {
    const int triangle = exits[i].triangle;
    std::uint64_t weight = 0;
    for (; i < exits.size() && exits[i].triangle == triangle; ++i) weight += exits[i].weight;
    const std::uint64_t root = (weight + (1U << 14)) >> 15;  // in units of 2^-16
    Score& sample = scores[static_cast<std::size_t>(triangle)];
    add(sample.weight, weight);
    add(sample.square, root * root);
  }
  exits.clear();
}

struct LightTally {
  std::vector<Score> exits;  ///< per surface sample
  WalkTally walk;
};

LightTally trace(const WalkScene& scene, const Entry& entry, std::uint32_t light,
                 std::uint64_t seed, std::uint64_t photons, const std::string& stage,
                 Progress& progress) {
  constexpr std::uint64_t piece = 256;
  const PhiloxKey key{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)};
  LightTally tally;
  tally.exits.resize(scene.surface.size());
  std::mutex lock;
  std::uint64_t batch = 16 * piece, last = 0;
  for (std::uint64_t first = 0; first < photons; first = last) {
    last = std::min(first + batch, photons);
    progress.update(stage, static_cast<double>(first) / static_cast<double>(photons), "");
    const Stopwatch watch;
    for_rows(static_cast<int>((last - first + piece - 1) / piece), [&](int row) {
      PhotonWalk walk(scene, key, light);
      WalkTally here;
      std::vector<Exit> exits;
      const std::uint64_t begin = first + static_cast<std::uint64_t>(row) * piece;
      for (std::uint64_t photon = begin; photon < std::min(begin + piece, last); ++photon) {
        walk.begin(static_cast<std::uint32_t>(photon));
        walk.follow(entry.start(walk), exits, here);
        score(exits, tally.exits);
      }
      const std::lock_guard guard(lock);
      tally.walk += here;
    });
    if (watch.seconds() < seconds_per_update / 2.0) batch *= 2;
  }
  progress.update(stage, 1.0, "");
  return tally;
}

void require(bool holds, const std::string& what) {
  if (!holds) throw InputError(what);
}

void validate(const ObjectProblem& problem, const ObjectOptions& options) {
  boundary_constants(problem.eta);
  check_problem(problem, options);
  for (std::size_t m = 0; m < problem.lights.size(); ++m) {
    const std::string name = "light " + std::to_string(m);
    const ObjectLight& light = problem.lights[m];
    for (const double irradiance : light.diffuse) {
      require(irradiance >= 0.0 && std::isfinite(irradiance),
              name + " has the diffuse irradiance " + std::to_string(irradiance) +
                  " somewhere; it must be finite and not negative");
    }
    for (const Beam& beam : light.beams) {
      require(beam.power >= 0.0 && std::isfinite(beam.power) && beam.position.allFinite() &&
                  std::abs(beam.direction.norm() - 1.0) < 1e-6,
              name + " has a beam without triangle, power, position or direction");
      if (!begins_inside(beam, problem.surface.normal[static_cast<std::size_t>(beam.triangle)]))
        continue;
      const auto ahead = MeshWalls(problem).ahead(beam.position, beam.direction);
      require(ahead && ahead->triangle == beam.triangle,
              name + " has a beam that arrives from inside the object; let it arrive from outside");
    }
  }
}

class ObjectMonteCarlo final : public ObjectModel {
 public:
  void describe(const OptionVisitor& visit) override {
    visit({"photons", "Monte Carlo", "", "", photons_bounds, "Photons per light and channel"},
          &photons_);
  }

  ObjectResult solve(const ObjectProblem& problem, const ObjectOptions& options,
                     Progress& progress) override {
    validate(problem, options);
    const Stopwatch watch;
    const WalkScene scene(problem, options);
    const Patches patches =
        make_patches(problem.surface, bounding_box(problem.mesh), patches_across);
    ObjectResult result;
    WalkTally all;
    double slipped = 0.0;
    for (std::size_t m = 0; m < problem.lights.size(); ++m) {
      const Entry entry(problem, scene, problem.lights[m]);
      LightTally tally;
      tally.exits.resize(problem.surface.size());
      if (entry.power() > 0.0) {
        const std::string stage = "photons of light " + std::to_string(m + 1) + " of " +
                                  std::to_string(problem.lights.size());
        tally = trace(scene, entry, static_cast<std::uint32_t>(m), options.seed, photons_, stage,
                      progress);
      }
      add_light(problem, patches, photons_, entry.power(), tally, result);
      all += tally.walk;
      slipped = std::max(slipped, static_cast<double>(tally.walk.slipped) / Score::full_weight /
                                      static_cast<double>(photons_));
    }
    result.seconds = watch.seconds();
    result.elements = photons_;
    const auto worst = std::max_element(result.error_estimate.begin(), result.error_estimate.end());
    const double error = worst == result.error_estimate.end() ? 0.0 : *worst;
    result.converged = error <= options.tolerance;
    result.message = std::to_string(photons_) +
                     formatted(
                         " photons per light give the exitance within %g %% (one standard "
                         "error, 2-norm over patches of 1/8 of the object)",
                         100.0 * error);
    add_warnings(all, slipped, result);
    return result;
  }

 private:
  static void add_light(const ObjectProblem& problem, const Patches& patches, std::uint64_t photons,
                        double entering, const LightTally& tally, ObjectResult& result) {
    const auto n = static_cast<double>(photons);
    const auto power = [&](std::uint64_t weight) {
      return entering * static_cast<double>(weight) / Score::full_weight / n;
    };
    std::vector<double> exitance, errors;
    std::uint64_t exiting = 0;
    for (std::size_t i = 0; i < tally.exits.size(); ++i) {
      const Score& sample = tally.exits[i];
      const double scale = entering / problem.surface.area[i];
      const double mean = scale * sample.mean(photons);
      const double error = scale * (sample.weight > 0 ? sample.standard_error(photons) : 1.0 / n);
      exitance.push_back(mean);
      errors.push_back(error);
      exiting += sample.weight;
    }
    double signal = 0.0, noise = 0.0;
    const std::vector<double> means = patches.mean(exitance, problem.surface);
    const std::vector<double> noises = patches.error_of_mean(exitance, errors, problem.surface);
    for (std::size_t p = 0; p < patches.size(); ++p) {
      signal += patches.area[p] * means[p] * means[p];
      noise += patches.area[p] * noises[p] * noises[p];
    }
    result.exitance.insert(result.exitance.end(), exitance.begin(), exitance.end());
    result.standard_error.insert(result.standard_error.end(), errors.begin(), errors.end());
    // The noise is in the signal's square, too; where there is nothing else, the error is all of
    // it.
    const double true_signal = std::max(signal - noise, noise);
    result.error_estimate.push_back(true_signal > 0.0 ? std::sqrt(noise / true_signal) : 0.0);
    ObjectBalance balance;
    balance.entering = entering + power(tally.walk.entered_again);
    balance.unscattered = power(tally.walk.unscattered);
    balance.exiting = power(exiting);
    balance.absorbed = power(tally.walk.absorbed);
    balance.reentering = power(tally.walk.reentering);
    result.balance.push_back(balance);
  }

  static void add_warnings(const WalkTally& all, double slipped, ObjectResult& result) {
    const double ratio =
        static_cast<double>(all.tentative) / std::max(1.0, static_cast<double>(all.collisions));
    if (ratio > slow_tentative_ratio) {
      result.warnings.push_back(
          formatted("the densest voxel extinguishes %g times as much as the "
                    "mean one, which slows Monte Carlo by that factor",
                    ratio));
    }
    if (slipped > most_slipped) {
      result.warnings.push_back(
          formatted("%g %% of the light left by rounding at edges of "
                    "triangles; parts of the mesh may be too thin for single "
                    "precision",
                    100.0 * slipped));
    }
  }

  std::uint64_t photons_ = 1'000'000;
};

}  // namespace

ModelDescription monte_carlo_model() {
  return {.name = "montecarlo",
          .text = "Random walks of photons: transport itself, right where diffusion is not.",
          .limits = "Its error is noise, which four times the photons halve.",
          .can = {.heterogeneous = true,
                  .voids = true,
                  .several_bodies = true,
                  .inner_light = true,
                  .reentry = true,
                  .transport = true},
          .make = [] { return std::make_unique<ObjectMonteCarlo>(); },
          .measured = &measured("montecarlo")};
}

}  // namespace kappamu::forward
