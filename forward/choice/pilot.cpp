#include "forward/choice/pilot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/random.h"
#include "core/shown_text.h"
#include "forward/choice/correction.h"
#include "forward/choice/error_belief.h"
#include "forward/patches.h"

namespace kappamu::forward {

namespace {

/// Of the photons expected: the first walk, and what is always walked; beyond, walks may take this
/// share of the seconds that the next candidate takes. Each walk is longer than the last by
/// `growth`.
constexpr double first_walk = 1.0, usual_walk = 2.0, share_of_next = 0.25, growth = 1.4;
/// Standard deviation of the logarithm of what is left of an error over what is expected.
constexpr double spread_of_left = 0.4;
/// Probabilities of an error being below: what is stated, and what answers are corrected for.
constexpr double stated = 0.95, likely = 0.5;

/// Squared difference of an answer from a walk over patches, the walk's noise taken off, over the
/// answer's square; with its standard deviation.
void compare(const Patches& patches, const Surface& surface, const std::vector<double>& answer,
             const std::vector<double>& walk, const std::vector<double>& standard_error,
             ErrorBelief& belief) {
  const std::vector<double> mean = patches.mean(answer, surface);
  const std::vector<double> walked = patches.mean(walk, surface);
  const std::vector<double> error = patches.error_of_mean(walk, standard_error, surface);
  double difference = 0.0, variance = 0.0, cross = 0.0, signal = 0.0, area = 0.0;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const double noise = error[p] * error[p];
    difference += patches.area[p] * (std::pow(walked[p] - mean[p], 2) - noise);
    variance += 2.0 * std::pow(patches.area[p] * noise, 2);
    cross += 4.0 * std::pow(patches.area[p], 2) * noise;
    area += patches.area[p];
    signal += patches.area[p] * mean[p] * mean[p];
  }
  if (signal == 0.0) return;
  // Noise times difference, as if that were the same everywhere: of a patch alone it is not known.
  variance += cross * std::max(0.0, difference) / area;
  belief.square = difference / signal;
  belief.square_deviation = std::sqrt(variance) / signal;
}

/// Of all photons of two answers `share` are those of `more`.
void add(const ObjectResult& more, double share, ObjectResult& sum) {
  const auto error = [](const ObjectResult& result, std::size_t s) {
    return result.exitance[s] > 0.0 ? result.standard_error[s] : 0.0;
  };
  for (std::size_t i = 0; i < sum.exitance.size(); ++i) {
    sum.standard_error[i] = std::hypot((1.0 - share) * error(sum, i), share * error(more, i));
    sum.exitance[i] += share * (more.exitance[i] - sum.exitance[i]);
  }
  for (std::size_t l = 0; l < sum.balance.size(); ++l) {
    for (const auto part :
         {&ObjectBalance::entering, &ObjectBalance::unscattered, &ObjectBalance::exiting,
          &ObjectBalance::absorbed, &ObjectBalance::reentering}) {
      sum.balance[l].*part += share * (more.balance[l].*part - sum.balance[l].*part);
    }
  }
}

/// Random walks of all channels in two halves, lengthened on demand.
class Walks {
 public:
  Walks(std::span<const ObjectProblem> problems, const ChoiceOptions& asked, Progress& progress)
      : problems_(problems), asked_(asked), progress_(progress) {}

  std::uint64_t photons() const { return 2 * photons_; }
  const ObjectResult& half(std::size_t which, std::size_t channel) const {
    return halves_[which][channel];
  }
  ObjectResult both(std::size_t channel) const {
    ObjectResult sum = halves_[0][channel];
    add(halves_[1][channel], 0.5, sum);
    return sum;
  }

  void lengthen(double photons) {
    const auto wanted = static_cast<std::uint64_t>(std::ceil(0.5 * photons));
    if (wanted < photons_ + 2) return;
    ChoiceOptions options = asked_;
    options.photons = wanted - photons_;
    const auto model = make_chosen(transport_model(), options);
    for (std::size_t which = 0; which < halves_.size(); ++which) {
      options.seed = key_of({asked_.seed, which, photons_});
      for (std::size_t c = 0; c < problems_.size(); ++c) {
        ObjectResult more = model->solve(problems_[c], options, progress_);
        if (photons_ == 0) {
          halves_[which].push_back(std::move(more));
        } else {
          add(more, static_cast<double>(options.photons) / static_cast<double>(wanted),
              halves_[which][c]);
        }
      }
    }
    photons_ = wanted;
  }

 private:
  std::span<const ObjectProblem> problems_;
  const ChoiceOptions& asked_;
  Progress& progress_;
  std::uint64_t photons_ = 0;  ///< of a half
  std::array<std::vector<ObjectResult>, 2> halves_;
};

/// Models of one equation, such as cubes cut by the surface and whole voxels: where walks do not
/// correct one's answer they do not correct the other's.
bool err_alike(const ModelCandidate& one, const ModelCandidate& other) {
  const ErrorLaw* law = object_model(one.model).errs_by;
  return law != nullptr && law == object_model(other.model).errs_by;
}

/// How many photons the first candidate's answer is worth.
double most_photons(const Choice& choice, double tolerance) {
  const ModelCandidate& first = choice.candidates.front();
  const auto next =
      std::find_if(choice.candidates.begin(), choice.candidates.end(),
                   [&](const ModelCandidate& c) { return &c != &first && !err_alike(c, first); });
  if (next == choice.candidates.end() || !next->error || *next->error > tolerance)
    return std::numeric_limits<double>::infinity();
  return std::max(usual_walk * first.photons,
                  share_of_next * *next->seconds / choice.seconds_per_photon);
}

/// One object, its models' answers and its walks.
class Corrected {
 public:
  Corrected(std::span<const ObjectProblem> problems, std::span<const ObjectFeatures> channels)
      : problems_(problems),
        channels_(channels),
        patches_(make_patches(problems.front().surface, bounding_box(problems.front().mesh),
                              patches_across)),
        correction_(problems.front().surface) {}

  /// What the walks show of the pilot's uncorrected results: each half's correction is compared
  /// with the other half. What it leaves is more than both halves leave together, by as much as
  /// their noise leads to expect.
  void judge(const Walks& walks, Pilot& pilot) {
    likely_errors_.clear();
    pilot.left = pilot.measured = 0.0;
    const ErrorLaw& law = object_model(pilot.model).measured->error;
    for (std::size_t c = 0; c < problems_.size(); ++c) {
      const Surface& surface = problems_[c].surface;
      const ObjectResult both = walks.both(c);
      for (std::size_t l = 0; l < problems_[c].lights.size(); ++l) {
        const std::vector<double> answer = of_light(pilot.results[c].exitance, c, l);
        const std::vector<double> walk = of_light(both.exitance, c, l);
        const std::vector<double> noise = of_light(both.standard_error, c, l);
        ErrorBelief own{error_by(law, channels_[c]), law.spread};
        compare(patches_, surface, answer, walk, noise, own);
        likely_errors_.push_back(error_quantile(own, likely));
        ErrorBelief left{correction_.left(answer, walk, noise, likely_errors_.back()),
                         spread_of_left};
        for (std::size_t which = 0; which < 2; ++which) {
          const ObjectResult &one = walks.half(which, c), &other = walks.half(1 - which, c);
          const std::vector<double> its_walk = of_light(one.exitance, c, l);
          const std::vector<double> its_noise = of_light(one.standard_error, c, l);
          const double likely_error = likely_errors_.back();
          const CorrectedAnswer corrected =
              correction_.corrected(answer, its_walk, its_noise, likely_error);
          ErrorBelief half{corrected.left};
          compare(patches_, surface, corrected.exitance, of_light(other.exitance, c, l),
                  of_light(other.standard_error, c, l), half);
          const double share = half.law > 0.0 ? 0.5 * std::pow(left.law / half.law, 2) : 0.5;
          left.square += share * half.square;
          left.square_deviation = std::hypot(left.square_deviation, share * half.square_deviation);
        }
        pilot.left = std::max(
            {pilot.left, error_quantile(left, stated), std::sqrt(std::max(0.0, left.square))});
        pilot.measured = std::max(pilot.measured, std::sqrt(std::max(0.0, own.square)));
      }
    }
  }

  /// The results as judge() left them, corrected by both halves.
  void correct(const Walks& walks, Pilot& pilot) const {
    std::size_t next = 0;
    for (std::size_t c = 0; c < problems_.size(); ++c) {
      const ObjectResult both = walks.both(c);
      ObjectResult& result = pilot.results[c];
      for (std::size_t l = 0; l < problems_[c].lights.size(); ++l) {
        const std::vector<double> corrected =
            correction_
                .corrected(of_light(result.exitance, c, l), of_light(both.exitance, c, l),
                           of_light(both.standard_error, c, l), likely_errors_[next++])
                .exitance;
        std::copy(corrected.begin(), corrected.end(),
                  result.exitance.begin() + static_cast<std::ptrdiff_t>(l * corrected.size()));
        const double numerics = std::min(result.error_estimate[l], pilot.left);
        result.error_estimate[l] = numerics;
        result.model_error[l] = std::sqrt(pilot.left * pilot.left - numerics * numerics);
      }
      result.balance = both.balance;
    }
  }

 private:
  std::vector<double> of_light(const std::vector<double>& values, std::size_t channel,
                               std::size_t light) const {
    const std::size_t samples = problems_[channel].surface.size();
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(light * samples);
    return {first, first + static_cast<std::ptrdiff_t>(samples)};
  }

  std::span<const ObjectProblem> problems_;
  std::span<const ObjectFeatures> channels_;
  Patches patches_;
  Correction correction_;
  std::vector<double> likely_errors_;  ///< of every channel and light
};

}  // namespace

std::optional<Pilot> run_pilot(std::span<const ObjectProblem> problems,
                               std::span<const ObjectFeatures> channels, const ChoiceOptions& asked,
                               Choice& choice, Progress& progress) {
  std::optional<Pilot> last;
  if (choice.candidates.front().photons <= 0.0) return last;
  Corrected object(problems, channels);
  Walks walks(problems, asked, progress);
  while (choice.candidates.front().photons > 0.0) {
    ModelCandidate& candidate = choice.candidates.front();
    Pilot pilot;
    pilot.model = candidate.model;
    const double expected = candidate.photons;
    try {
      progress.update("choice of a model", 0.0, candidate.model + ": " + candidate.reason);
      const ModelDescription& model = object_model(pilot.model);
      const ChoiceOptions options = options_for(model, channels, asked);
      pilot.results = make_chosen(model, options)->solve_channels(problems, options, progress);
    } catch (const InputError& refusal) {
      candidate = {pilot.model, {}, {}, 0.0, std::string("refused: ") + refusal.what()};
      rank(choice, asked.tolerance);
      continue;
    }
    const double most =
        std::min(most_photons(choice, asked.tolerance), static_cast<double>(asked.photons));
    for (double photons = first_walk * expected; photons <= most; photons *= growth) {
      walks.lengthen(photons);
      object.judge(walks, pilot);
      pilot.within = pilot.left <= asked.tolerance;
      if (pilot.within) break;
    }
    pilot.photons = walks.photons();
    candidate.photons = pilot.within ? static_cast<double>(pilot.photons) : 0.0;
    candidate.error = pilot.left;
    candidate.reason = (pilot.within ? "corrected by " : "left after ") +
                       std::to_string(pilot.photons) + " photons, which measured its error as " +
                       shown_number(100.0 * pilot.measured, "%.2g") +
                       " % before the correction and at most " +
                       shown_number(100.0 * pilot.left, "%.2g") + " % after it";
    if (pilot.within) object.correct(walks, pilot);
    last = std::move(pilot);
    if (last->within) return last;
    for (ModelCandidate& other : choice.candidates) {
      if (!other.error || other.photons <= 0.0 || !err_alike(other, candidate)) continue;
      other.error = candidate.error;
      other.photons = 0.0;
      other.reason = "errs as " + candidate.model + ": " + candidate.reason;
    }
    rank(choice, asked.tolerance);
  }
  return last;
}

}  // namespace kappamu::forward
