#include "forward/analytic/homogeneous_block.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "forward/grid/grid_physics.h"

namespace kappamu::forward {

namespace {

using std::numbers::pi;

/// Of the uniform mode's response, and of what enters: less does not count, nor could it be seen.
constexpr double least_response = 1e-12, least_seen = 1e-15;

/// α of mode `order`: αX = orderπ + 2 atan(g/α), whose left side less the right one rises with α.
double mode_wavenumber(int order, double length, double g) {
  if (g == 0.0) return order * pi / length;
  double low = order * pi / length;
  double high = (order + 1) * pi / length;
  constexpr int to_rounding = 52;
  for (int k = 0; k < to_rounding; ++k) {
    const double middle = 0.5 * (low + high);
    (middle * length > order * pi + 2.0 * std::atan2(g, middle) ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

/// A smooth function of k², linear between nodes even in log(1 + k²d²).
class Spectrum {
 public:
  template <class Function>
  Spectrum(double largest, double length, const Function& of) : square_(length * length) {
    const double end = std::log1p(largest * square_);
    per_ = (nodes - 1) / end;
    for (int k = 0; k < nodes; ++k) {
      value_.push_back(of(std::expm1(end * k / (nodes - 1)) / square_));
    }
  }
  double operator()(double wavenumber_squared) const {
    const double at = per_ * std::log1p(wavenumber_squared * square_);
    const int below = std::min(static_cast<int>(at), nodes - 2);
    const auto k = static_cast<std::size_t>(below);
    return value_[k] + (at - below) * (value_[k + 1] - value_[k]);
  }

 private:
  static constexpr int nodes = 256;
  double square_, per_;
  std::vector<double> value_;
};

Eigen::MatrixXd rows_of(const Eigen::MatrixXd& matrix, const std::vector<int>& rows) {
  return matrix(rows, Eigen::all);
}

}  // namespace

HomogeneousBlock::Axis HomogeneousBlock::modes(int voxels, double voxel_mm, double g) {
  const double length = voxels * voxel_mm;
  Axis axis;
  axis.mean.resize(voxels, voxels);
  axis.first.resize(voxels);
  axis.last.resize(voxels);
  for (int j = 0; j < voxels; ++j) {
    const double alpha = mode_wavenumber(j, length, g);
    const double psi = g == 0.0 ? 0.0 : std::atan2(g, alpha);
    const double square =
        alpha == 0.0 ? length : 0.5 * length + std::sin(2.0 * psi) / (2.0 * alpha);
    const double half = 0.5 * alpha * voxel_mm;
    const double sinc = half == 0.0 ? 1.0 : std::sin(half) / half;
    const double unit = 1.0 / std::sqrt(square);
    axis.wavenumber.push_back(alpha);
    for (int i = 0; i < voxels; ++i) {
      axis.mean(i, j) = unit * sinc * std::cos(alpha * (i + 0.5) * voxel_mm - psi);
    }
    axis.first[j] = unit * std::cos(psi);
    axis.last[j] = unit * std::cos(alpha * length - psi);
  }
  return axis;
}

HomogeneousBlock::HomogeneousBlock(const GridSetup& setup, Face seen,
                                   const std::vector<double>& irradiance, FacePixels pixels)
    : setup_(setup), seen_(seen), pixels_(std::move(pixels)), irradiance_(&irradiance) {
  const BoundaryConstants constants = constants_of(setup);
  robin_A_ = constants.A;
  q_ = boundary_q_per_irradiance(setup, constants);
  scale_ = exitance_per_flux(setup);
  if (setup.source == SourceModel::first_collision) beam_ = constants.normal_transmittance;
  reflectance_ = fresnel_internal(setup.eta, 1.0);
  // What q sends back unchanged does not spread: it is counted pixel by pixel, apart from the
  // modes.
  apart_ = exitance_per_irradiance(setup, constants) - scale_ * q_ / (2.0 * robin_A_);
}

void HomogeneousBlock::set_sides(double g) {
  if (g == g_) return;
  g_ = g;
  const FaceShape lit = face_shape(setup_.shape, setup_.lit_face);
  const double h = setup_.shape.voxel_mm;
  axis_ = {modes(lit.nu, h, g), modes(lit.nv, h, g)};
  waves_.clear();
}

void HomogeneousBlock::set_waves(Eigen::Index u, Eigen::Index v) {
  const auto& [along_u, along_v] = axis_;
  if (!waves_.empty()) {
    if (waves_.front().rows() >= u && waves_.front().cols() >= v) return;
    // Absorption rises from call to call: not one more mode each time.
    u = std::min(along_u.mean.cols(), std::max(u, 3 * waves_.front().rows() / 2));
    v = std::min(along_v.mean.cols(), std::max(v, 3 * waves_.front().cols() / 2));
    waves_.clear();
  }
  const FaceShape lit = face_shape(setup_.shape, setup_.lit_face);
  const double area = setup_.shape.voxel_mm * setup_.shape.voxel_mm;
  for (std::size_t at = 0; at < irradiance_->size(); at += lit.cells()) {
    const Eigen::Map<const Eigen::MatrixXd> map(irradiance_->data() + at, lit.nu, lit.nv);
    const Eigen::MatrixXd of_u = along_u.mean.leftCols(u).transpose() * map;
    waves_.emplace_back(area * (of_u * along_v.mean.leftCols(v)));
  }
}

/// Where the responses are asked: one of a face across the light, one of each slice of a side.
std::vector<double> HomogeneousBlock::depths() const {
  const int along = axis_of(setup_.lit_face);
  if (axis_of(seen_) == along) return {seen_ == setup_.lit_face ? 0.0 : setup_.thickness_mm()};
  std::vector<double> result;
  const int slices = setup_.shape.extent(along);
  for (const int i : face_axes(seen_)[0] == along ? pixels_.u : pixels_.v) {
    const int slice = is_plus(setup_.lit_face) ? slices - 1 - i : i;
    result.push_back((slice + 0.5) * setup_.shape.voxel_mm);
  }
  return result;
}

/// Exitance of a wave that the modes carry, per irradiance; of a slice of a side by Simpson's rule.
double HomogeneousBlock::response(const LayeredMode& mode, double depth) const {
  const double half = 0.5 * setup_.shape.voxel_mm;
  const bool side = axis_of(seen_) != axis_of(setup_.lit_face);
  const double end = std::min(depth + half, setup_.thickness_mm());
  const double fluence = side ? (mode.fluence(std::max(0.0, depth - half)) +
                                 4.0 * mode.fluence(depth) + mode.fluence(end)) /
                                    6.0
                              : mode.fluence(depth);
  return scale_ * fluence / (2.0 * robin_A_);
}

/// [u][v] of the pixels of a side face.
Eigen::MatrixXd HomogeneousBlock::through_side(const std::vector<Eigen::MatrixXd>& filters,
                                               const Eigen::MatrixXd& waves) const {
  const bool across_first = axis_of(seen_) == face_axes(setup_.lit_face)[0];
  const bool depth_first = face_axes(seen_)[0] == axis_of(setup_.lit_face);
  const Axis& normal = axis_[across_first ? 0 : 1];
  const Eigen::VectorXd& end = is_plus(seen_) ? normal.last : normal.first;
  const Eigen::MatrixXd along =
      rows_of(axis_[across_first ? 1 : 0].mean, depth_first ? pixels_.v : pixels_.u);
  Eigen::MatrixXd result(along.rows(), static_cast<Eigen::Index>(filters.size()));
  for (std::size_t d = 0; d < filters.size(); ++d) {
    const Eigen::MatrixXd field = waves.cwiseProduct(filters[d]);
    const Eigen::VectorXd left =
        across_first ? Eigen::VectorXd(field.transpose() * end) : Eigen::VectorXd(field * end);
    result.col(static_cast<Eigen::Index>(d)) = along * left;
  }
  if (depth_first) result.transposeInPlace();
  return result;
}

std::vector<double> HomogeneousBlock::exitance(double kappa, double mu) {
  set_sides(setup_.sides == Sides::open ? 1.0 / (2.0 * robin_A_ * kappa) : 0.0);
  const double thickness = setup_.thickness_mm();
  const std::array<Layer, 1> layers{{{kappa, mu, thickness}}};
  const auto& [along_u, along_v] = axis_;
  const auto square = [](double x) { return x * x; };
  const double largest = square(along_u.wavenumber.back()) + square(along_v.wavenumber.back());
  std::vector<Spectrum> spectra;
  for (const double depth : depths()) {
    spectra.emplace_back(std::max(largest, 1.0), thickness, [&](double wavenumber_squared) {
      return response(LayeredMode(layers, robin_A_, {wavenumber_squared, beam_, q_, reflectance_}),
                      depth);
    });
  }
  const bool side = axis_of(seen_) != axis_of(setup_.lit_face);
  const auto arriving = [&](const Axis& axis) {
    Eigen::Index modes = axis.mean.cols();
    const auto arrives = [&](const Spectrum& spectrum) {
      const double last = axis.wavenumber[static_cast<std::size_t>(modes - 1)];
      return std::abs(spectrum(square(last))) >
             std::max(least_seen, least_response * std::abs(spectrum(0.0)));
    };
    while (!side && modes > 1 && std::none_of(spectra.begin(), spectra.end(), arrives)) --modes;
    return modes;
  };
  set_waves(arriving(along_u), arriving(along_v));
  std::vector<Eigen::MatrixXd> filters;
  for (const Spectrum& spectrum : spectra) {
    Eigen::MatrixXd& filter = filters.emplace_back(waves_.front().rows(), waves_.front().cols());
    for (Eigen::Index j = 0; j < filter.cols(); ++j) {
      for (Eigen::Index i = 0; i < filter.rows(); ++i) {
        filter(i, j) = spectrum(square(along_u.wavenumber[static_cast<std::size_t>(i)]) +
                                square(along_v.wavenumber[static_cast<std::size_t>(j)]));
      }
    }
  }
  const auto at_pixels = [side](const Axis& axis, Eigen::Index modes,
                                const std::vector<int>& pixels) -> Eigen::MatrixXd {
    return side ? Eigen::MatrixXd() : rows_of(axis.mean.leftCols(modes), pixels);
  };
  const Eigen::MatrixXd u = at_pixels(along_u, waves_.front().rows(), pixels_.u);
  const Eigen::MatrixXd v = at_pixels(along_v, waves_.front().cols(), pixels_.v);
  const FaceShape lit = face_shape(setup_.shape, setup_.lit_face);
  std::vector<double> result;
  for (std::size_t m = 0; m < waves_.size(); ++m) {
    Eigen::MatrixXd map = side ? through_side(filters, waves_[m])
                               : u * waves_[m].cwiseProduct(filters.front()) * v.transpose();
    if (seen_ == setup_.lit_face && apart_ != 0.0) {
      const Eigen::Map<const Eigen::MatrixXd> light(irradiance_->data() + m * lit.cells(), lit.nu,
                                                    lit.nv);
      map += apart_ * light(pixels_.u, pixels_.v);
    }
    result.insert(result.end(), map.data(), map.data() + map.size());
  }
  return result;
}

}  // namespace kappamu::forward
