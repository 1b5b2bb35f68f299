#include "studies/sfdi/lateral_table.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "core/optics.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "forward/lateral/half_space_walk.h"
#include "forward/lateral/lateral_basis.h"
#include "forward/lateral/lateral_diffusion.h"
#include "io/atomic_file.h"

namespace kappamu::studies::sfdi {

namespace {

namespace fw = forward;

const std::vector<double> anisotropies{0.7, 0.8, 0.9, 0.95}, indices{1.33, 1.4, 1.5};
constexpr int nodes_m = 22, nodes_c = 9;

struct Nodes {
  std::vector<double> m, c;
  std::vector<fw::LateralPoint> points;  ///< [m][c]
};

/// Chebyshev's points of v and of c = 3a/m².
Nodes nodes() {
  Nodes result;
  const auto point = [](int i, int n) {
    return 0.5 - 0.5 * std::cos(std::numbers::pi * (i + 0.5) / n);
  };
  for (int i = 0; i < nodes_m; ++i) {
    const double v = fw::lateral_v(fw::lateral_largest_m) * point(i, nodes_m);
    result.m.push_back(2.0 * v / (1.0 - v));
  }
  for (int j = 0; j < nodes_c; ++j) result.c.push_back(point(j, nodes_c));
  for (const double m : result.m) {
    for (const double c : result.c) {
      result.points.push_back({c * m * m / 3.0, m * std::sqrt(1.0 - c)});
    }
  }
  return result;
}

struct Fit {
  Eigen::VectorXd coefficients;
  std::vector<double> error;  ///< [m] largest of standard error and residual over c, relative
  double chi_square = 0.0;    ///< per degree of freedom
};

/// ln(transport/diffusion) = v Σ t_ij T_i T_j, weighted by the Monte Carlo's standard errors.
Fit fit(const Nodes& at, const double* value, const double* standard_error, double robin_A) {
  const auto rows = static_cast<Eigen::Index>(at.points.size());
  constexpr int unknowns = fw::lateral_orders_v * fw::lateral_orders_q;
  Eigen::MatrixXd matrix(rows, unknowns);
  Eigen::VectorXd right(rows);
  std::vector<double> sigma;
  for (Eigen::Index row = 0; row < rows; ++row) {
    const fw::LateralPoint& p = at.points[row];
    const fw::LateralPlace place = fw::lateral_place(p.a, p.k);
    const auto tv = fw::chebyshev_v(place.v);
    const auto tq = fw::chebyshev_q(place.q);
    sigma.push_back(standard_error[row] / value[row]);
    for (int i = 0; i < unknowns; ++i) {
      matrix(row, i) = place.v * tv.value[i / fw::lateral_orders_q] *
                       tq.value[i % fw::lateral_orders_q] / sigma[row];
    }
    right[row] = std::log(value[row] / fw::diffuse_half_space(p.a, p.k, robin_A)) / sigma[row];
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(matrix);
  const Eigen::VectorXd solution = qr.solve(right);
  const Eigen::VectorXd residual = matrix * solution - right;
  Fit result{solution, std::vector<double>(nodes_m, 0.0),
             residual.squaredNorm() / static_cast<double>(rows - unknowns)};
  for (Eigen::Index row = 0; row < rows; ++row) {
    double& error = result.error[row / nodes_c];
    error = std::max(error, sigma[row] * std::max(1.0, std::abs(residual[row])));
  }
  return result;
}

std::string numbers(const auto& values, const char* format) {
  std::string text;
  for (const double value : values)
    text += (text.empty() ? "" : ", ") + shown_number(value, format);
  return text;
}

}  // namespace

void measure_walks(const Request& request, Progress& progress, const Save& save) {
  const Nodes at = nodes();
  const double photons = request.number("photons", request.size == Size::full ? 1.6e7 : 1e5);
  Json walks = Json::array();
  for (std::size_t g = 0; g < anisotropies.size(); ++g) {
    progress.update("white Monte Carlo",
                    static_cast<double>(g) / static_cast<double>(anisotropies.size()),
                    "g " + shown_number(anisotropies[g]));
    fw::WalkOptions options;
    options.anisotropy = anisotropies[g];
    options.indices = indices;
    options.photons = static_cast<std::uint64_t>(photons);
    options.seed = request.seed;
    const Stopwatch watch;
    const fw::WhiteReflectance walk = fw::walk_half_space(options, at.points);
    walks.push_back({{"g", anisotropies[g]},
                     {"photons", photons},
                     {"seconds", watch.seconds()},
                     {"value", walk.value},
                     {"standard_error", walk.standard_error}});  // [index][m][c]
    save({{"m", at.m}, {"c", at.c}, {"indices", indices}, {"walks", walks}});
  }
}

void measure_table(const Request& request, Progress&, const Save& save) {
  const Nodes at = nodes();
  const Json record = read_record(request.folder / "sfdi-walks.json", "sfdi");
  std::string coefficients, errors;
  Json rows = Json::array();
  for (const Json& walk : record.at("walks")) {
    const auto value = walk.at("value").get<std::vector<double>>();
    const auto standard_error = walk.at("standard_error").get<std::vector<double>>();
    std::vector<double> error(nodes_m, 0.0);
    coefficients += "    {{\n";
    for (std::size_t n = 0; n < indices.size(); ++n) {
      const std::size_t first = n * at.points.size();
      const Fit fitted =
          fit(at, &value[first], &standard_error[first], boundary_constants(indices[n]).A);
      for (int i = 0; i < nodes_m; ++i) error[i] = std::max(error[i], fitted.error[i]);
      coefficients += "{{" + numbers(fitted.coefficients, "%.6g") + "}},\n";
      rows.push_back(
          {{"g", walk.at("g")},
           {"n", indices[n]},
           {"photons", walk.at("photons")},
           {"chi_square", fitted.chi_square},
           {"largest_error", *std::max_element(fitted.error.begin(), fitted.error.end())}});
    }
    coefficients += "    }},\n";
    errors += "    {{" + numbers(error, "%.2g") + "}},\n";
  }
  const std::string head =
      "// Written by `kappamu-studies sfdi table`: do not edit. Transport over diffusion of a "
      "half-space\n// (lateral_basis.h), and its relative standard error at the m of each row.\n";
  io::write_text_atomically(
      request.folder / "lateral_table.inc",
      head + "constexpr std::array<double, " + std::to_string(anisotropies.size()) +
          "> table_anisotropy{" + numbers(anisotropies, "%g") +
          "};\nconstexpr std::array<double, " + std::to_string(indices.size()) + "> table_index{" +
          numbers(indices, "%g") +
          "};\n// [anisotropy][index]\nconstexpr std::array<std::array<LateralCoefficients, " +
          std::to_string(indices.size()) + ">, " + std::to_string(anisotropies.size()) +
          "> table_coefficients{{\n" + coefficients + "}};\nconstexpr std::array<double, " +
          std::to_string(nodes_m) + "> table_m{" + numbers(at.m, "%.5g") +
          "};\n// [anisotropy][m]\nconstexpr std::array<std::array<double, " +
          std::to_string(nodes_m) + ">, " + std::to_string(anisotropies.size()) +
          "> table_error{{\n" + errors + "}};\n");
  save({{"rows", rows}});
}

}  // namespace kappamu::studies::sfdi
