// Weighted least squares for the inverse response; see response.h for the model.
#include "capture/response/response.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/response/response_curve.h"
#include "core/error.h"
#include "core/numbers/median.h"

namespace kappamu::capture {
namespace {

// Error of ln exposure no averaging removes (shutter, block texture under the curve's bend).
constexpr double log_exposure_floor = 0.002;
// Samples whose mean is nearer to black than this many of their standard errors say too little, and
// the logarithm would bias them: at 20 the bias is 1/(2 * 20^2) = 0.13 %.
constexpr double least_signal_to_noise = 20.0;
constexpr double tukey_constant = 4.685;  // 95 % efficiency on normal errors, as Huber's
constexpr double huber_constant = 1.345;
constexpr int unknowns = 192;    // of s
constexpr int plain_rounds = 2;  // until the weights fit the slope of the curve
constexpr int huber_rounds = 4;
constexpr int tukey_rounds = 3;

// All observations of one scene block; its unknown ln irradiance is eliminated.
using Group = std::vector<CurveObservation>;

std::vector<Group> usable_groups(const std::vector<ResponseSample>& samples,
                                 const ResponseCurve& curve) {
  constexpr int block_pixels = sample_block_px * sample_block_px;
  std::vector<Group> groups;
  for (const ResponseSample& sample : samples) {
    Group group;
    for (std::size_t j = 0; j < sample.code.size(); ++j) {
      if (sample.valid[j] == 0) continue;
      CurveObservation seen;
      seen.code = sample.code[j];
      seen.log_exposure = sample.log_exposure[j];
      // Noise of the mean; rounding averages out only as far as noise moves the codes about.
      constexpr double rounding_variance = 1.0 / 12.0;
      const double dither = std::min(1.0, sample.variance[j] / rounding_variance);
      seen.code_variance = sample.variance[j] / block_pixels +
                           rounding_variance * (1.0 - dither + dither / block_pixels);
      const double signal = seen.code - curve.black();
      if (signal < least_signal_to_noise * std::sqrt(seen.code_variance)) continue;
      curve.locate(seen.code, seen);
      group.push_back(seen);
    }
    if (group.size() >= 2) groups.push_back(std::move(group));
  }
  return groups;
}

// Residual of each observation against its group's weighted mean; calls visit(observation, r).
template <class Visit>
void for_each_residual(std::vector<Group>& groups, const ResponseCurve& curve, const Visit& visit) {
  for (Group& group : groups) {
    double sum = 0.0;
    double weights = 0.0;
    for (const CurveObservation& seen : group) {
      sum += seen.weight * (curve.g(seen) - seen.log_exposure);
      weights += seen.weight;
    }
    const double mean = weights > 0.0 ? sum / weights : 0.0;
    for (CurveObservation& seen : group) visit(seen, curve.g(seen) - seen.log_exposure - mean);
  }
}

// Slopes of a curve that is flat or falls somewhere are bounded away from zero.
double safe_slope(const ResponseCurve& curve, const CurveObservation& seen) {
  return std::max(curve.slope(seen), 1e-3 / (seen.code - curve.black()));
}

void weigh_by_noise(std::vector<Group>& groups, const ResponseCurve& curve) {
  for (Group& group : groups) {
    for (CurveObservation& seen : group) {
      const double slope = safe_slope(curve, seen);
      const double floor = log_exposure_floor / slope;
      seen.total_variance = seen.code_variance + floor * floor;
      seen.robust = 1.0;
      seen.weight = 1.0 / (slope * slope * seen.total_variance);
    }
  }
}

enum class Robust { huber, tukey };

// Weights the residuals down in units of their robust spread: by Huber's function, which has one
// minimum and so finds its way from a poor curve, or by Tukey's, which then drops outliers
// altogether. Returns the share cut off (Tukey) or bounded (Huber).
double weigh_down_outliers(std::vector<Group>& groups, const ResponseCurve& curve, Robust robust) {
  std::vector<double> sizes;
  for_each_residual(groups, curve, [&](CurveObservation& seen, double residual) {
    sizes.push_back(std::abs(residual) * std::sqrt(seen.weight));
  });
  if (sizes.empty()) return 0.0;
  const double spread =
      std::max(upper_median(sizes) / 0.6745, 1.0);  // never below the noise itself
  const double cut = (robust == Robust::tukey ? tukey_constant : huber_constant) * spread;
  std::size_t beyond = 0;
  std::size_t at = 0;
  for (Group& group : groups) {
    for (CurveObservation& seen : group) {
      const double u = sizes[at++] / cut;
      beyond += u >= 1.0 ? 1 : 0;
      if (robust == Robust::tukey) {
        seen.robust = u < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
      } else {
        seen.robust = 1.0 / std::max(u, 1.0);
      }
      seen.weight *= seen.robust;
    }
  }
  return static_cast<double>(beyond) / static_cast<double>(sizes.size());
}

// Normal equations of s after elimination of each group's ln irradiance:
// sum of w (phi·s + y)² over observations, phi and y centred within the group.
struct NormalEquations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double freedom = 0.0;  // observations less groups
};

NormalEquations assemble(const std::vector<Group>& groups, int knots) {
  NormalEquations normal{Eigen::MatrixXd::Zero(knots, knots), Eigen::VectorXd::Zero(knots)};
  Eigen::VectorXd mean(knots);
  for (const Group& group : groups) {
    mean.setZero();
    double mean_y = 0.0;
    double weights = 0.0;
    int used = 0;
    for (const CurveObservation& seen : group) {
      const double y = seen.base - seen.log_exposure;
      const std::array<double, 2> phi{1.0 - seen.weight_1, seen.weight_1};
      for (int a = 0; a < 2; ++a) {
        for (int b = 0; b < 2; ++b) {
          normal.matrix(seen.knot + a, seen.knot + b) += seen.weight * phi[a] * phi[b];
        }
        normal.right[seen.knot + a] -= seen.weight * phi[a] * y;
        mean[seen.knot + a] += seen.weight * phi[a];
      }
      mean_y += seen.weight * y;
      weights += seen.weight;
      used += seen.weight > 0.0 ? 1 : 0;
    }
    if (used == 0) continue;
    normal.freedom += used - 1;
    for (const CurveObservation& left : group) {
      for (int a = 0; a < 2; ++a) {
        const int i = left.knot + a;
        if (mean[i] == 0.0) continue;
        const double scaled = mean[i] / weights;
        for (const CurveObservation& other : group) {
          for (int b = 0; b < 2; ++b) {
            const double share = (b == 0 ? 1.0 - other.weight_1 : other.weight_1) * other.weight;
            normal.matrix(i, other.knot + b) -= scaled * share;
          }
        }
        normal.right[i] += scaled * mean_y;
        mean[i] = 0.0;  // each knot of the group once
      }
    }
  }
  return normal;
}

// Sum of squared third differences of s: parabolas in v, so also a power law that bends, are free.
Eigen::MatrixXd roughness(int knots) {
  Eigen::MatrixXd penalty = Eigen::MatrixXd::Zero(knots, knots);
  const Eigen::Vector4d difference(-1.0, 3.0, -3.0, 1.0);
  for (int k = 0; k + 3 < knots; ++k) {
    penalty.block<4, 4>(k, k) += difference * difference.transpose();
  }
  return penalty;
}

// Squared residuals in units of the codes' noise. Measured in codes, not in ln exposure: with equal
// ratios between exposures a staircase of that ratio fits every ln exposure and hides the noise on
// its flat steps, but it explains no code.
double code_misfit(std::vector<Group>& groups, const ResponseCurve& curve) {
  double sum = 0.0;
  for_each_residual(groups, curve, [&](const CurveObservation& seen, double residual) {
    const double codes = residual / safe_slope(curve, seen);
    sum += seen.robust * codes * codes / seen.total_variance;
  });
  return sum;
}

// Solves for half decades of the smoothness weight and keeps the curve of the least generalised
// cross-validation score; returns its weight.
double solve(std::vector<Group>& groups, ResponseCurve& curve) {
  const int knots = curve.knots();
  const NormalEquations normal = assemble(groups, knots);
  Eigen::MatrixXd gauge = Eigen::MatrixXd::Zero(knots, knots);
  gauge(knots - 1, knots - 1) = normal.matrix.trace();  // s = 0 at the largest code
  const Eigen::MatrixXd penalty = roughness(knots);
  const double scale = normal.matrix.trace() / knots;
  double best_score = std::numeric_limits<double>::infinity();
  double best_weight = 0.0;
  ResponseCurve best = curve;
  for (int half_decade = -2; half_decade <= 16; ++half_decade) {
    const double weight = scale * std::pow(10.0, 0.5 * half_decade);
    const Eigen::LDLT<Eigen::MatrixXd> factored(normal.matrix + gauge + weight * penalty);
    curve.s() = factored.solve(normal.right);
    curve.s().array() -= curve.s()[knots - 1];
    const double freedom = normal.freedom - factored.solve(normal.matrix).trace();
    if (freedom <= 1.0) continue;
    const double score = code_misfit(groups, curve) / (freedom * freedom);
    if (score < best_score) {
      best_score = score;
      best_weight = weight;
      best = curve;
    }
  }
  curve = best;
  return best_weight;
}

}  // namespace

RecoveredResponse recover_response(const std::vector<ResponseSample>& samples, int bit_depth,
                                   double black_level, const std::string& name) {
  const int top = (1 << bit_depth) - 1;
  double highest = black_level;
  for (const ResponseSample& sample : samples) {
    for (std::size_t j = 0; j < sample.code.size(); ++j) {
      if (sample.valid[j] != 0) highest = std::max(highest, sample.code[j]);
    }
  }
  ResponseCurve curve(black_level, bit_depth, unknowns, highest);
  std::vector<Group> groups = usable_groups(samples, curve);

  RecoveredResponse recovered;
  ResponseReport& report = recovered.report;
  report.samples = static_cast<int>(groups.size());
  report.lowest_code = top;
  for (const Group& group : groups) {
    report.observations += static_cast<int>(group.size());
    for (const CurveObservation& seen : group) {
      report.lowest_code = std::min(report.lowest_code, seen.code);
      report.highest_code = std::max(report.highest_code, seen.code);
    }
  }
  if (report.highest_code - report.lowest_code < 0.25 * (top - black_level)) {
    throw InputError(
        name + ": the exposure stacks do not hold enough to recover the camera's response (" +
        std::to_string(report.samples) +
        " blocks seen well in two exposures, over less than a quarter of the code range); " +
        "add exposure times, or, if the frames are linear, state that (camera.encoding of a "
        "session, the option linear of a folder of photographs).");
  }

  for (int round = 0; round < plain_rounds + huber_rounds + tukey_rounds; ++round) {
    weigh_by_noise(groups, curve);
    if (round >= plain_rounds) {
      const Robust robust = round < plain_rounds + huber_rounds ? Robust::huber : Robust::tukey;
      report.outlier_share = weigh_down_outliers(groups, curve, robust);
    }
    report.smoothness = solve(groups, curve);
  }
  double squares = 0.0;
  double weights = 0.0;
  for_each_residual(groups, curve, [&](const CurveObservation& seen, double residual) {
    squares += seen.weight * residual * residual;
    weights += seen.weight;
  });
  report.residual_rms = weights > 0.0 ? std::sqrt(squares / weights) : 0.0;

  recovered.linear.resize(static_cast<std::size_t>(top) + 1);
  for (int code = 0; code <= top; ++code) {
    recovered.linear[static_cast<std::size_t>(code)] = curve.linear(code);
  }
  report.pooled_codes = make_rising(recovered.linear);
  const double scale = recovered.linear.back();
  for (double& value : recovered.linear) value /= scale;
  return recovered;
}

}  // namespace kappamu::capture
