#include "inverse/fit/start.h"

#include <cmath>

#include "core/error.h"
#include "core/shown_text.h"
#include "inverse/data_checks/physics_choice.h"
#include "inverse/defaults.h"
#include "inverse/optimise/settle_correction.h"

namespace kappamu::inverse {

namespace {

HomogeneousFit by_diffusion(const FitRun& run) {
  const PathOptions& path = run.options.path;
  std::optional<HomogeneousGuess> guess;
  if (path.start_kappa) guess = {*path.start_kappa, path.start_mu.value()};
  try {
    return find_homogeneous(run.grid.levels()[0], guess);
  } catch (const InputError& error) {
    throw InputError(run.stage_name + ": " + error.what(), error.options());
  }
}

/// From the best homogeneous block by diffusion.
void choose_physics(FitRun& run, const HomogeneousFit& start) {
  const FitOptions& options = run.options;
  if (options.data.physics != Physics::automatic) return run.set_physics(options.data.physics);
  if (run.grid.objective().backend_name().starts_with("reference")) {
    run.warn(
        "Photons need an OpenCL device, and there is none: the fit is by diffusion, and how far "
        "that is off is not known.");
    return run.set_physics(Physics::diffusion);
  }
  run.progress.update(run.stage_name, 0.0, "asking photons whether diffusion holds");
  PhysicsChoice choice =
      inverse::choose_physics(run.grid.levels()[0], start, options.solver.backend,
                              *predict_options(options, Physics::transport).photons);
  run.set_physics(choice.physics);
  run.state.report.physics_reason = std::move(choice.reason);
  run.count(choice.solves);
}

HomogeneousFit by_transport(FitRun& run, HomogeneousFit start) {
  constexpr double tolerance = defaults::start_tolerance;
  const Eigen::Array2d unit =
      (defaults::start_certain / tolerance * start.deviation.array()).max(1.0);
  const auto cells = run.grid.shape().cells();
  const double move =
      settle_correction((start.logs().array() / unit).matrix(), tolerance, defaults::most_starts,
                        [&](const Eigen::VectorXd& at) {
                          const Eigen::Array2d p = at.array() * unit;
                          run.grid.objective().refresh_correction(
                              run.grid.refinement(), {Vector(cells, p[0]), Vector(cells, p[1])},
                              Objective::PhotonSlope::renewed);
                          start.jacobian.resize(0, 0);  // without this slope
                          start = refit_homogeneous(run.grid.objective(), start);
                          return Eigen::VectorXd(start.logs().array() / unit);
                        });
  if (move >= tolerance) {
    run.warn(
        formatted("The ratio of transport to diffusion has not settled: its last renewal moved the "
                  "homogeneous block by a factor of %.2g. Do not trust this fit.",
                  std::exp(move)));
  }
  return start;
}

}  // namespace

PredictOptions predict_options(const FitOptions& options, Physics physics) {
  PredictOptions how;
  how.backend = options.solver.backend;
  how.convention = options.data.convention;
  if (physics == Physics::transport) {
    how.photons = {.device = how.backend.device,
                   .seed = options.solver.seed,
                   .anisotropy = options.data.anisotropy};
  }
  return how;
}

HomogeneousFit find_start(FitRun& run) {
  HomogeneousFit start = by_diffusion(run);
  choose_physics(run, start);
  if (run.state.report.physics == Physics::transport) start = by_transport(run, std::move(start));
  if (!start.converged) {
    run.warn("The homogeneous start did not converge; the volumes may depend on where it stopped.");
  }
  return start;
}

}  // namespace kappamu::inverse
