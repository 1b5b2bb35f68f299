#include "forward/analytic/layered_block.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <string>

#include "core/error.h"
#include "core/numbers/cosine_transform.h"
#include "core/processor_time.h"
#include "forward/grid/grid_physics.h"

namespace kappamu::forward {

namespace {

using std::numbers::pi;

/// Highest frequency summed, in pixel frequencies 2π/h.
constexpr int alias_rings = 12;
/// Coefficients of a layer may differ by this much, relatively: what a float file rounds away.
constexpr double uniform_within = 1e-6;

/// The frequencies that a pixel grid of n pixels of edge h cannot tell from m, with the weight of
/// each in the mean over a pixel of light that is constant on pixels.
struct Alias {
  double wavenumber_squared;  // [1/mm²]
  double weight;              // sinc²; the weights of all aliases sum to 1
};
std::vector<Alias> aliases(int m, int n, double h) {
  std::vector<Alias> list;
  for (int j = -alias_rings; j <= alias_rings; ++j) {
    const double half_turns = static_cast<double>(m) / n + 2.0 * j;  // kh/π, signed
    if (m == 0 && j != 0) continue;  // a pixel averages its own multiples to nothing
    const double a = 0.5 * pi * half_turns;
    const double sinc = a == 0.0 ? 1.0 : std::sin(a) / a;
    list.push_back({half_turns * half_turns * pi * pi / (h * h), sinc * sinc});
  }
  return list;
}

/// Flux out of both ends per incident irradiance, for one pixel frequency.
struct Response {
  double near = 0.0, far = 0.0;
};

class LateralModes {
 public:
  LateralModes(const GridSetup& setup, const std::vector<Layer>& layers)
      : face_(face_shape(setup.shape, setup.lit_face)), u_(face_.nu), v_(face_.nv) {
    const BoundaryConstants constants = constants_of(setup);
    ModeSource source;
    source.q = boundary_q_per_irradiance(setup, constants);
    if (setup.source == SourceModel::first_collision) source.beam = constants.normal_transmittance;
    const double scale = exitance_per_flux(setup);
    // Where q enters, −q/(2A) leaves unchanged at every frequency: its aliases sum to 1 exactly.
    const double instant = -scale * source.q / (2.0 * constants.A);
    const double apart = exitance_per_irradiance(setup, constants) + instant;
    const double h = setup.shape.voxel_mm;
    response_.resize(face_.cells());
    for (int n = 0; n < face_.nv; ++n) {
      const auto along_v = aliases(n, face_.nv, h);
      for (int m = 0; m < face_.nu; ++m) {
        Response& sum = response_[static_cast<std::size_t>(n) * face_.nu + m];
        for (const Alias& a : aliases(m, face_.nu, h)) {
          for (const Alias& b : along_v) {
            source.wavenumber_squared = a.wavenumber_squared + b.wavenumber_squared;
            const LayeredMode mode(layers, constants.A, source);
            const double weight = a.weight * b.weight;
            sum.near += weight * (scale * mode.flux_out_near() - instant);
            sum.far += weight * scale * mode.flux_out_far();
          }
        }
        sum.near += apart;
      }
    }
  }

  /// Exitance [v][u] of the lit face and the one opposite.
  std::array<std::vector<double>, 2> exitance(const double* irradiance) const {
    // Column-major: [u][v] of a map [v][u].
    const Eigen::Map<const Eigen::MatrixXd> map(irradiance, face_.nu, face_.nv);
    const Eigen::MatrixXd waves = to_waves(u_, v_, map);
    const auto back = [&](double Response::*share) {
      Eigen::MatrixXd answer = waves;
      for (std::size_t k = 0; k < response_.size(); ++k) answer.data()[k] *= response_[k].*share;
      answer = from_waves(u_, v_, answer);
      return std::vector<double>(answer.data(), answer.data() + answer.size());
    };
    return {back(&Response::near), back(&Response::far)};
  }

 private:
  FaceShape face_;
  CosineTransform u_, v_;
  std::vector<Response> response_;
};

class AnalyticModel final : public ForwardModel {
 public:
  ForwardResult solve(const ForwardProblem& problem, const ForwardOptions& /*options*/,
                      Progress& /*progress*/) const override {
    const GridSetup& setup = problem.setup;
    validate(setup);
    validate_medium(setup.shape, problem.medium.kappa.values(), problem.medium.mu.values());
    if (setup.sides != Sides::mirror) {
      throw InputError(
          "method analytic answers only blocks with mirror sides; use mirror sides or another "
          "method",
          {{"sides", "mirror"}, {"method"}});
    }
    const Stopwatch setting_up;
    const std::vector<Layer> layers = layers_along_light(setup, problem.medium);
    const LateralModes modes(setup, layers);
    ForwardResult result;
    result.backend = "analytic, serial double";
    result.setup_seconds = setting_up.seconds();

    const Stopwatch solving;
    const FaceShape lit = face_shape(setup.shape, setup.lit_face);
    const auto patterns = static_cast<std::size_t>(problem.patterns);
    check(problem.irradiance.size() == patterns * lit.cells(), "analytic: wrong irradiances");
    for (std::size_t f = 0; f < all_faces.size(); ++f) {
      result.exitance[f].assign(face_shape(setup.shape, all_faces[f]).cells() * patterns, 0.0);
    }
    for (std::size_t m = 0; m < patterns; ++m) {
      const double* irradiance = &problem.irradiance[m * lit.cells()];
      const auto ends = modes.exitance(irradiance);
      const auto at = static_cast<std::ptrdiff_t>(m * lit.cells());
      const auto near = static_cast<std::size_t>(setup.lit_face);
      const auto far = static_cast<std::size_t>(opposite(setup.lit_face));
      std::copy(ends[0].begin(), ends[0].end(), result.exitance[near].begin() + at);
      std::copy(ends[1].begin(), ends[1].end(), result.exitance[far].begin() + at);
      result.balance.push_back(
          balance(setup, layers, std::accumulate(irradiance, irradiance + lit.cells(), 0.0), ends));
    }
    result.seconds = solving.seconds();
    result.termination = Termination::converged;
    result.message = "closed form, " + std::to_string(layers.size()) +
                     (layers.size() == 1 ? " layer" : " layers");
    return result;
  }

 private:
  /// What does not leave is absorbed: closed forms leave no residual to report.
  static PowerBalance balance(const GridSetup& setup, const std::vector<Layer>& layers,
                              double irradiance_sum,
                              const std::array<std::vector<double>, 2>& ends) {
    const double area = setup.shape.voxel_mm * setup.shape.voxel_mm;
    PowerBalance b;
    b.entering = constants_of(setup).normal_transmittance * irradiance_sum * area;
    if (setup.source == SourceModel::first_collision) {
      double optical_depth = 0.0;
      for (const Layer& layer : layers) optical_depth += layer.thickness / (3.0 * layer.kappa);
      b.unscattered = b.entering * std::exp(-optical_depth);
    }
    const auto total = [&](const std::vector<double>& map) {
      return area * std::accumulate(map.begin(), map.end(), 0.0);
    };
    const double near = total(ends[0]), far = total(ends[1]);
    b.exiting[static_cast<std::size_t>(setup.lit_face)] = near;
    b.exiting[static_cast<std::size_t>(opposite(setup.lit_face))] = far;
    b.absorbed = b.entering - b.unscattered - near - far;
    return b;
  }
};

}  // namespace

std::vector<Layer> layers_along_light(const GridSetup& setup, const Medium& medium) {
  const FaceShape face = face_shape(setup.shape, setup.lit_face);
  const int depth = setup.shape.extent(axis_of(setup.lit_face));
  const double h = setup.shape.voxel_mm;
  std::vector<Layer> layers;
  for (int w = 0; w < depth; ++w) {
    const std::size_t first = face_cell(setup.shape, setup.lit_face, 0, 0, w);
    const double kappa = medium.kappa[first], mu = medium.mu[first];
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        const std::size_t i = face_cell(setup.shape, setup.lit_face, u, v, w);
        const bool same_kappa = std::abs(medium.kappa[i] - kappa) <= uniform_within * kappa;
        const bool same_mu = std::abs(medium.mu[i] - mu) <= uniform_within * mu;
        if (same_kappa && same_mu) continue;
        throw InputError("method analytic needs coefficients that vary along the light only, but " +
                         std::string(same_kappa ? "mu" : "kappa") + " varies across it in layer " +
                         std::to_string(w) + " below face " + to_string(setup.lit_face) +
                         "; use another method");
      }
    }
    if (!layers.empty() && layers.back().kappa == kappa && layers.back().mu == mu) {
      layers.back().thickness += h;
    } else {
      layers.push_back({kappa, mu, h});
    }
  }
  return layers;
}

std::unique_ptr<ForwardModel> make_analytic_model() {
  return std::make_unique<AnalyticModel>();
}

}  // namespace kappamu::forward
