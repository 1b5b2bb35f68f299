// Which equation a fit obeys, and the homogeneous start by transport.
#include <cmath>
#include <utility>

#include "core/shown_text.h"
#include "inverse/data_checks/physics_choice.h"
#include "inverse/fit/channel_run.h"
#include "inverse/optimise/settle_correction.h"

namespace kappamu::inverse {

namespace {

/// A start that r, renewed, moves by less [log units] is transport's: the search for a model goes
/// on from there.
constexpr double start_tolerance = 0.02;
constexpr int most_starts = 8;

}  // namespace

PredictOptions predict_options(const FitOptions& options, Physics physics) {
  PredictOptions how;
  how.backend = options.solver.backend;
  how.convention = options.data.convention;
  if (physics == Physics::transport) how.photons = {how.backend.device, options.solver.seed};
  return how;
}

void ChannelRun::set_physics(Physics physics) {
  state_.report.physics = physics;
  grid_.set_photons(predict_options(options_, physics).photons);
}

/// From the best homogeneous block by diffusion.
void ChannelRun::choose_physics(double kappa, double mu) {
  if (options_.data.physics != Physics::automatic) return set_physics(options_.data.physics);
  PhysicsChoice choice = inverse::choose_physics(grid_.levels()[0], kappa, mu);
  if (choice.physics == Physics::transport &&
      grid_.objective().backend_name().starts_with("reference")) {
    warn(choice.reason + " Yet photons need an OpenCL device, and there is none: by diffusion.");
    choice = {};
  }
  set_physics(choice.physics);
  state_.report.physics_reason = std::move(choice.reason);
}

HomogeneousFit ChannelRun::refit_by_transport(HomogeneousFit start) {
  const auto cells = grid_.shape().cells();
  const double move =
      settle_correction(Eigen::Vector2d(std::log(start.kappa), std::log(start.mu)), start_tolerance,
                        most_starts, [&](const Eigen::VectorXd& at) {
                          grid_.objective().refresh_correction(
                              grid_.refinement(), {Vector(cells, at[0]), Vector(cells, at[1])},
                              Objective::PhotonSlope::renewed);
                          start.jacobian.resize(0, 0);  // without this slope
                          start = refit_homogeneous(grid_.objective(), start);
                          return Eigen::Vector2d(std::log(start.kappa), std::log(start.mu));
                        });
  if (move < start_tolerance) return start;
  warn(
      formatted("The ratio of transport to diffusion has not settled: its last renewal moved the "
                "homogeneous block by a factor of %.2g. Do not trust this fit.",
                std::exp(move)));
  return start;
}

}  // namespace kappamu::inverse
