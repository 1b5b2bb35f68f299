#include "inverse/optimise/lateral_modes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>

#include "core/parallel.h"

namespace kappamu::inverse {

namespace {

/// Planes a thread transforms at once: as many doubles as a cache line holds, so that no two
/// threads write to one line of the coefficients.
constexpr int planes_at_once = 8;

}  // namespace

double laplacian_eigenvalue(int k, int n) {
  return 2.0 - 2.0 * std::cos(std::numbers::pi * k / n);
}

LateralModes::LateralModes(const MediumSpace& space)
    : shape_(space.shape),
      axis_a_(space.depth_axis == 0 ? 1 : 0),
      axis_b_(space.depth_axis == 2 ? 1 : 2),
      depth_axis_(space.depth_axis),
      na_(shape_.extent(axis_a_)),
      nb_(shape_.extent(axis_b_)),
      depth_(space.depth()),
      cosines_a_(na_),
      cosines_b_(nb_) {
  // Bins as wide as the lowest frequency of the longer side.
  const double longest = std::max(na_, nb_);
  for (int b = 0; b < nb_; ++b) {
    for (int a = 0; a < na_; ++a) {
      laplacian_.push_back(laplacian_eigenvalue(a, na_) + laplacian_eigenvalue(b, nb_));
      const double frequency = std::hypot(a * longest / na_, b * longest / nb_);
      const auto bin = static_cast<std::size_t>(std::lround(frequency));
      if (bin >= members_.size()) members_.resize(bin + 1);
      members_[bin].push_back(b * na_ + a);
    }
  }
}

/// Values of the plane at depth d, as [a][b] of `field`.
template <class Field>
auto LateralModes::plane(Field& field, int d) const {
  using Plane = std::conditional_t<std::is_const_v<Field>, const Eigen::MatrixXd, Eigen::MatrixXd>;
  const std::array<Eigen::Index, 3> stride{1, shape_.nx,
                                           static_cast<Eigen::Index>(shape_.nx) * shape_.ny};
  const auto along = [&](int axis) { return stride[static_cast<std::size_t>(axis)]; };
  return Eigen::Map<Plane, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>(
      field.data() + d * along(depth_axis_), na_, nb_, {along(axis_b_), along(axis_a_)});
}

/// Calls work(first, count) for groups of rows of the coefficients, on all cores.
template <class Work>
void LateralModes::for_planes(const Work& work) const {
  for_rows((rows() + planes_at_once - 1) / planes_at_once, [&](int group) {
    const int first = group * planes_at_once;
    work(first, std::min(planes_at_once, rows() - first));
  });
}

double LateralModes::mean_laplacian(int bin) const {
  double mean = 0.0;
  for (const int wave : members(bin)) {
    mean += laplacian_[static_cast<std::size_t>(wave)] / static_cast<double>(members(bin).size());
  }
  return mean;
}

Eigen::MatrixXd LateralModes::analyse(const CoefficientPair& fields) const {
  const Eigen::Index waves = static_cast<Eigen::Index>(na_) * nb_;
  Eigen::MatrixXd coefficients(rows(), waves);
  for_planes([&](int first, int count) {
    Eigen::MatrixXd planes(waves, count);
    for (int p = 0; p < count; ++p) {
      const int row = first + p;
      const auto& field = row < depth_ ? fields.log_kappa : fields.log_mu;
      Eigen::Map<Eigen::MatrixXd>(planes.col(p).data(), na_, nb_) = plane(field, row % depth_);
      to_waves(cosines_a_, cosines_b_, planes.col(p).data());
    }
    coefficients.middleRows(first, count) = planes.transpose();
  });
  return coefficients;
}

/// Fields of planes [a][b] that `back` makes of each row of coefficients, in place.
template <class Back>
CoefficientPair LateralModes::fields_of(const Eigen::MatrixXd& coefficients,
                                        const Back& back) const {
  CoefficientPair fields{std::vector<double>(shape_.cells()), std::vector<double>(shape_.cells())};
  for_planes([&](int first, int count) {
    Eigen::MatrixXd planes = coefficients.middleRows(first, count).transpose();
    for (int p = 0; p < count; ++p) {
      const int row = first + p;
      auto& field = row < depth_ ? fields.log_kappa : fields.log_mu;
      Eigen::Map<Eigen::MatrixXd> image(planes.col(p).data(), na_, nb_);
      back(image);
      plane(field, row % depth_) = image;
    }
  });
  return fields;
}

CoefficientPair LateralModes::synthesise(const Eigen::MatrixXd& coefficients) const {
  return fields_of(coefficients, [&](Eigen::Map<Eigen::MatrixXd>& image) {
    from_waves(cosines_a_, cosines_b_, image.data());
  });
}

CoefficientPair LateralModes::spread(const Eigen::MatrixXd& variances) const {
  const auto squares = [](const CosineTransform& transform, int n) -> Eigen::MatrixXd {
    return transform.forward(Eigen::MatrixXd::Identity(n, n)).cwiseAbs2();
  };
  const Eigen::MatrixXd a = squares(cosines_a_, na_);
  const Eigen::MatrixXd b = squares(cosines_b_, nb_);
  return fields_of(variances, [&](Eigen::Map<Eigen::MatrixXd>& image) {
    image = (a.transpose() * image * b).eval();
  });
}

}  // namespace kappamu::inverse
