#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"
#include "forward/shells/circle_area.h"
#include "studies/shells/shells_bench.h"

namespace kappamu::studies {

using namespace forward::shells;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// Largest and mean error of shares of a texel.
struct Errors {
  double largest = 0.0, sum = 0.0;
  int count = 0;
  void add(double error) {
    largest = std::max(largest, std::abs(error));
    sum += std::abs(error);
    ++count;
  }
  Json row(const std::string& what) const {
    return {{"what", what}, {"largest", largest}, {"mean", sum / count}, {"cases", count}};
  }
};

/// [K] eq. 1: the area beyond a chord that lies d inside the circle.
double chord(double radius, double d) {
  if (d <= 0.0) return 0.0;
  const double m = std::sqrt(d * (2.0 * radius - d));
  return 4.0 / 3.0 * d * m + d * d * d / (4.0 * m);
}
/// Exact: the area of the disc where u > radius − d.
double exact_chord(double radius, double d) {
  return disc_in_rectangle(radius, radius - d, -2.0, 2.0, 2.0);
}

HairTexture texture_of(const Request& request) {
  HairOptions options;
  options.seed = request.seed;
  if (request.size == Size::quick) {
    options.width = options.layers = 12;
    options.coats = {{800, 0.04, 0.10, 0.1, 0.45, 0.3}, {120, 0.10, 0.22, 0.5, 1.0, 0.3}};
  }
  return make_hair_texture(options);
}

/// About `count` of the texels with hair, drawn at random.
std::vector<std::size_t> some_texels(const HairTexture& texture, std::size_t count) {
  std::vector<std::size_t> texels, some;
  for (std::size_t i = 0; i < texture.size(); ++i) {
    if (texture.density[i] > 0.0F) texels.push_back(i);
  }
  const double share = static_cast<double>(count) / static_cast<double>(texels.size());
  for (const std::size_t texel : texels) {
    if (uniform(key_of({7, texel})) < share) some.push_back(texel);
  }
  return some;
}

/// Transmittance of texels along rays: [texel][ray].
Eigen::MatrixXd marched(const HairTexture& texture, double r,
                        const std::vector<std::size_t>& texels, const std::vector<Vector3d>& rays,
                        bool alone = false) {
  Eigen::MatrixXd t(static_cast<Eigen::Index>(texels.size()),
                    static_cast<Eigen::Index>(rays.size()));
  for_rows(static_cast<int>(texels.size()), [&](int i) {
    const Vector3d from = centre_of(texture, texels[static_cast<std::size_t>(i)]);
    for (std::size_t k = 0; k < rays.size(); ++k) {
      t(i, static_cast<Eigen::Index>(k)) = alone ? transmittance_alone(texture, r, from, rays[k])
                                                 : transmittance(texture, r, from, rays[k]);
    }
  });
  return t;
}

Eigen::MatrixXd basis_of(int bands, const std::vector<Vector3d>& rays) {
  Eigen::MatrixXd basis(harmonics_in(bands), static_cast<Eigen::Index>(rays.size()));
  for (std::size_t k = 0; k < rays.size(); ++k) {
    basis.col(static_cast<Eigen::Index>(k)) = harmonics(bands, rays[k]);
  }
  return basis;
}

Eigen::VectorXd values_of(const SkyLight& light, const std::vector<Vector3d>& rays) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(rays.size()));
  for (std::size_t k = 0; k < rays.size(); ++k) {
    values[static_cast<Eigen::Index>(k)] = light.radiance(rays[k]);
  }
  return values;
}

/// Σ|seen − truth| / Σ truth, over texels and over shells, both by the hair in them.
struct LightError {
  double texels = 0.0, shells = 0.0;
};
LightError light_error(const HairTexture& texture, const std::vector<std::size_t>& texels,
                       const Eigen::VectorXd& seen, const Eigen::VectorXd& truth) {
  const std::size_t layer = static_cast<std::size_t>(texture.width) * texture.width;
  std::vector<double> difference(static_cast<std::size_t>(texture.layers));
  LightError error;
  double sum = 0.0;
  for (std::size_t i = 0; i < texels.size(); ++i) {
    const double weight = texture.density[texels[i]];
    const auto row = static_cast<Eigen::Index>(i);
    error.texels += weight * std::abs(seen[row] - truth[row]);
    difference[texels[i] / layer] += weight * (seen[row] - truth[row]);
    sum += weight * truth[row];
  }
  for (const double d : difference) error.shells += std::abs(d) / sum;
  error.texels /= sum;
  return error;
}

}  // namespace

void fur_coverage(const Request& request, Progress& /*progress*/, const Save& save) {
  Errors chord_error, wedge_error, share_error;
  const int cases = request.size == Size::quick ? 2000 : 200'000;
  for (int i = 0; i < cases; ++i) {
    const auto random = [&](std::uint64_t k) {
      return uniform(key_of({request.seed, static_cast<std::uint64_t>(i), k}));
    };
    // The corner of four texels at (x, y) of the disc, whose centre is in the lower left.
    const double radius = 0.05 + 0.45 * random(0);
    const double x = radius * random(1), y = radius * random(2);
    const double area = pi * radius * radius;
    const double right = radius - x, upper = radius - y;
    chord_error.add((chord(radius, right) - exact_chord(radius, right)) /
                    std::max(exact_chord(radius, right), 1e-12));
    if (x * x + y * y >= radius * radius) continue;
    const double exact = disc_in_rectangle(radius, x, y, 2.0, 2.0);
    // Its legs: from the corner to the circle along both edges.
    const double s1 = std::sqrt(radius * radius - y * y) - x;
    const double s2 = std::sqrt(radius * radius - x * x) - y;
    const double wedge = 0.25 * pi * 0.25 * (s1 + s2) * (s1 + s2);
    wedge_error.add((wedge - exact) / std::max(exact, 1e-12));
    // Case 3: the texel that holds the disc's centre.
    const double first = area - (chord(radius, right) + chord(radius, upper) - wedge);
    share_error.add((first - disc_in_rectangle(radius, -2.0, -2.0, x, y)) / area);
  }
  save(
      {{"rows",
        {chord_error.row("chord, eq. 1, of its area"), wedge_error.row("wedge, eq. 2, of its area"),
         share_error.row("texel 1 of case 3, of the disc's area")}}});
}

void fur_symmetry(const Request& request, Progress& progress, const Save& save) {
  const HairTexture texture = texture_of(request);
  const auto texels = some_texels(texture, request.size == Size::quick ? 100 : 40'000);
  const int count = request.size == Size::quick ? 64 : 256;
  std::vector<Vector3d> random;
  for (int k = 0; k < count; ++k) {
    const auto key = [&](std::uint64_t i) { return key_of({9, static_cast<std::uint64_t>(k), i}); };
    const double z = 2.0 * uniform(key(0)) - 1.0, a = 2.0 * pi * uniform(key(1));
    const double across = std::sqrt(1.0 - z * z);
    random.emplace_back(across * std::cos(a), across * std::sin(a), z);
  }
  // The printed K_l^m over the right one: (l+|m|)!/(l−|m|)! for m < 0.
  Eigen::VectorXd printed = Eigen::VectorXd::Ones(25);
  for (int l = 0; l < 5; ++l) {
    for (int m = 1; m <= l; ++m) {
      for (int i = l - m + 1; i <= l + m; ++i) printed[l * (l + 1) - m] *= i;
    }
  }
  struct Variant {
    const char* name;
    bool alone, random, printed;
  };
  Json rows = Json::array();
  for (const Variant& v :
       {Variant{"wrapping, K right, even rays", false, false, false},
        Variant{"open border", true, false, false}, Variant{"K as printed", false, false, true},
        Variant{"random rays", false, true, false}}) {
    const std::vector<Vector3d> rays = v.random ? random : even_directions(count);
    const Eigen::MatrixXd t = marched(texture, texture.extinction, texels, rays, v.alone);
    Eigen::MatrixXd basis = basis_of(5, rays);
    if (v.printed) basis = printed.asDiagonal() * basis;
    const double weight = 4.0 * pi / static_cast<double>(rays.size());
    const Eigen::MatrixXd transfer = weight * t * basis.transpose();
    std::vector<double> side;
    double border = 0.0;
    for (int s = 0; s < 4; ++s) {
      const double angle = 0.5 * pi * s;
      const Vector3d axis(0.866 * std::cos(angle), 0.866 * std::sin(angle), 0.5);
      const SkyLight lobe{
          "", [axis](const Vector3d& d) { return std::pow(std::max(0.0, d.dot(axis)), 4.0); }};
      // Light by the same rays ([K] eq. 7).
      const Eigen::VectorXd lit = transfer * (weight * basis * values_of(lobe, rays));
      double sum = 0.0, all = 0.0, far = 0.0, near = 0.0, n = 0.0, f = 0.0;
      for (std::size_t i = 0; i < texels.size(); ++i) {
        const double w = texture.density[texels[i]], here = lit[static_cast<Eigen::Index>(i)];
        sum += w * here;
        all += w;
        const double x = centre_of(texture, texels[i]).x() / texture.width;
        if (s == 0 && x > 0.75) near += w * here, n += w;
        if (s == 0 && x < 0.25) far += w * here, f += w;
      }
      if (s == 0) border = (near / n) / (far / f);
      side.push_back(sum / all);
    }
    const auto [low, high] = std::minmax_element(side.begin(), side.end());
    rows.push_back({{"variant", v.name},
                    {"light from +x", side[0]},
                    {"from +y", side[1] / side[0]},
                    {"from -x", side[2] / side[0]},
                    {"from -y", side[3] / side[0]},
                    {"most over least", *high / *low},
                    {"quarter near the light over far one", border}});
    save({{"rows", rows}});
    progress.update("symmetry", static_cast<double>(rows.size()) / 4.0, "");
  }
}

void fur_transfer(const Request& request, Progress& progress, const Save& save) {
  const bool quick = request.size == Size::quick;
  const HairTexture texture = texture_of(request);
  const auto texels = some_texels(texture, quick ? 100 : 2000);
  const double r = texture.extinction;
  // The truth: other directions than any set of rays below has, turned off the axes.
  std::vector<Vector3d> fine;
  for (std::uint32_t k = 0; k < (quick ? 1024U : 8192U); ++k) {
    const auto [u, v] = sobol_point(k, 12345);
    const double z = 2.0 * u - 1.0, across = std::sqrt(1.0 - z * z);
    fine.emplace_back(across * std::cos(2.0 * pi * v), across * std::sin(2.0 * pi * v), z);
  }
  const Eigen::MatrixXd truth = marched(texture, r, texels, fine);
  progress.update("transfer", 0.5, "truth");
  Json rows = Json::array();
  for (const int count : quick ? std::vector{64} : std::vector{64, 256, 1024, 4096}) {
    const std::vector<Vector3d> rays = even_directions(count);
    const Eigen::MatrixXd all = 4.0 * pi / static_cast<double>(rays.size()) *
                                marched(texture, r, texels, rays) *
                                basis_of(most_bands, rays).transpose();
    for (const SkyLight& light : four_lights()) {
      const Eigen::VectorXd exact =
          4.0 * pi / static_cast<double>(fine.size()) * truth * values_of(light, fine);
      const Eigen::MatrixXd coefficients = projected(light, most_bands);
      for (int bands = 1; bands <= most_bands; ++bands) {
        const int size = harmonics_in(bands);
        const Eigen::VectorXd seen = all.leftCols(size) * coefficients.topRows(size);
        const LightError error = light_error(texture, texels, seen, exact);
        // Zonal about the normal: m = 0 alone.
        Eigen::VectorXd zonal = Eigen::VectorXd::Zero(seen.size());
        for (int l = 0; l < bands; ++l) zonal += all.col(l * (l + 1)) * coefficients(l * (l + 1));
        const LightError zonal_error = light_error(texture, texels, zonal, exact);
        rows.push_back({{"light", light.name},
                        {"rays", count},
                        {"bands", bands},
                        {"shells' error", error.shells},
                        {"texels' error", error.texels},
                        {"zonal: shells'", zonal_error.shells},
                        {"zonal: texels'", zonal_error.texels}});
      }
    }
    // A lamp: its own ray is the truth.
    const Vector3d lamp = Vector3d(std::cos(0.7), std::sin(0.7), 1.0).normalized();
    const Eigen::VectorXd exact = marched(texture, r, texels, {lamp});
    for (int bands = 1; bands <= most_bands; ++bands) {
      const int size = harmonics_in(bands);
      const Eigen::VectorXd seen =
          (all.leftCols(size) * harmonics(bands, lamp)).cwiseMax(0.0).cwiseMin(1.0);
      const LightError error = light_error(texture, texels, seen, exact);
      rows.push_back({{"light", "lamp at 45 deg"},
                      {"rays", count},
                      {"bands", bands},
                      {"shells' error", error.shells},
                      {"texels' error", error.texels}});
    }
    save({{"rows", rows}});
    progress.update("transfer", 0.75, std::to_string(count) + " rays");
  }
}

}  // namespace kappamu::studies
