// Which equation a fit obeys, and the homogeneous start by transport.
#include <cmath>

#include "core/shown_text.h"
#include "inverse/data_checks/physics_choice.h"
#include "inverse/fit/channel_run.h"
#include "inverse/optimise/settle_correction.h"

namespace kappamu::inverse {

namespace {

/// A start that r, renewed, moves by less [log units], or by less than a quarter of what structure
/// leaves uncertain, is transport's: the search for a model goes on from there.
constexpr double start_tolerance = 0.02;
constexpr double certain = 0.25;
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
void ChannelRun::choose_physics(const HomogeneousFit& start) {
  if (options_.data.physics != Physics::automatic) return set_physics(options_.data.physics);
  Objective& objective = grid_.objective();
  if (objective.backend_name().starts_with("reference")) {
    warn(
        "Photons need an OpenCL device, and there is none: the fit is by diffusion, and how far "
        "that is off is not known.");
    return set_physics(Physics::diffusion);
  }
  progress_.update(stage_name_, 0.0, "asking photons whether diffusion holds");
  PhysicsChoice choice =
      inverse::choose_physics(grid_.levels()[0], start, options_.solver.backend,
                              *predict_options(options_, Physics::transport).photons);
  set_physics(choice.physics);
  state_.report.physics_reason = std::move(choice.reason);
  SolveCount solves = objective.solves();
  solves.add(choice.solves);
  objective.restore(objective.correction(), solves);
}

HomogeneousFit ChannelRun::refit_by_transport(HomogeneousFit start) {
  const Eigen::Array2d unit = (certain / start_tolerance * start.deviation.array()).max(1.0);
  const auto cells = grid_.shape().cells();
  const double move =
      settle_correction((start.logs().array() / unit).matrix(), start_tolerance, most_starts,
                        [&](const Eigen::VectorXd& at) {
                          const Eigen::Array2d p = at.array() * unit;
                          grid_.objective().refresh_correction(
                              grid_.refinement(), {Vector(cells, p[0]), Vector(cells, p[1])},
                              Objective::PhotonSlope::renewed);
                          start.jacobian.resize(0, 0);  // without this slope
                          start = refit_homogeneous(grid_.objective(), start);
                          return Eigen::VectorXd(start.logs().array() / unit);
                        });
  if (move < start_tolerance) return start;
  warn(
      formatted("The ratio of transport to diffusion has not settled: its last renewal moved the "
                "homogeneous block by a factor of %.2g. Do not trust this fit.",
                std::exp(move)));
  return start;
}

}  // namespace kappamu::inverse
