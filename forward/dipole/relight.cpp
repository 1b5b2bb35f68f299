#include "forward/dipole/relight.h"

#include <algorithm>

#include "core/error.h"
#include "forward/dipole/hierarchy/hierarchy.h"
#include "forward/dipole/sum_check.h"
#include "forward/dipole/transmitted.h"

namespace kappamu::forward::dipole {

namespace {

std::vector<Profile> profiles_of(const MediaOfChannels& media, double eta) {
  std::vector<Profile> profiles;
  for (const auto& medium : media) {
    if (!medium->homogeneous()) {
      throw InputError("the dipole answers for a homogeneous medium alone; use the model embedded");
    }
    const Coefficients c = medium->smallest();
    profiles.push_back(make_profile("dipole", {c.kappa, c.mu}, eta));
  }
  return profiles;
}

/// Links that one core moves in a millisecond, about.
constexpr double links_per_ms = 5000.0;
constexpr double most_links = 1e12;  ///< without a limit

class Relight final : public LiveModel {
 public:
  Relight(const LiveBody& object, const ObjectOptions& options)
      : mesh_(object.mesh),
        surface_(object.surface),
        media_(object.media),
        solved_(object.media),
        eta_(object.eta),
        profiles_(profiles_of(object.media, object.eta)),
        check_(object.mesh, object.surface, object.surface.area, options.seed),
        hierarchy_(device::Context::chosen(options.device), object.mesh, profiles_) {}

  Answer solve(const LightOfChannels& light, int /*level*/, Progress& progress) override {
    progress.update("dipole", 0.0, "");
    if (solved_ != media_) {
      profiles_ = profiles_of(media_, eta_);
      hierarchy_.update(profiles_);
      solved_ = media_;
    }
    const std::size_t samples = surface_.size();
    std::vector<Eigen::Array4f> in(samples, Eigen::Array4f::Zero());
    for (std::size_t c = 0; c < 3; ++c) {
      const std::vector<double> entering = transmitted(surface_, eta_, light[c]);
      for (std::size_t t = 0; t < samples; ++t) {
        in[t][static_cast<Eigen::Index>(c)] = static_cast<float>(entering[t]);
      }
    }
    const std::vector<Eigen::Array4f> out = hierarchy_.exitance(in);
    Answer answer;
    answer.elements = samples;
    for (std::size_t c = 0; c < 3; ++c) {
      answer.exitance[c].reserve(samples);
      for (const Eigen::Array4f& value : out) {
        answer.exitance[c].push_back(static_cast<double>(value[static_cast<Eigen::Index>(c)]));
      }
    }
    return answer;
  }

  bool follow(double most_ms) override {
    const double most = std::clamp(links_per_ms * most_ms, 0.0, most_links);
    hierarchy_.set_most_changes(static_cast<std::size_t>(most));
    hierarchy_.update(mesh_, profiles_);
    return true;
  }
  bool caught_up() const override { return hierarchy_.changes().pending() == 0; }

  std::optional<double> measured_error(const LightOfChannels& light, int /*level*/,
                                       const ExitanceOfChannels& exitance,
                                       const ExitanceOfChannels& /*coarse*/) const override {
    double worst = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::vector<double> exact =
          check_.exact(profiles_[c], Placement::rotated, transmitted(surface_, eta_, light[c]));
      worst = std::max(worst, check_.error(exact, exitance[c]));
    }
    return worst;
  }

 private:
  const TriangleMesh& mesh_;
  const Surface& surface_;
  const MediaOfChannels& media_;
  MediaOfChannels solved_;  ///< that the hierarchy is of
  double eta_;
  std::vector<Profile> profiles_;
  SumCheck check_;
  Hierarchy hierarchy_;
};

}  // namespace

std::unique_ptr<LiveModel> make_relight(const LiveBody& object, const ObjectOptions& options) {
  return std::make_unique<Relight>(object, options);
}

}  // namespace kappamu::forward::dipole
