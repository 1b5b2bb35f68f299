#include "core/numbers/conjugate_gradients.h"

#include <cmath>
#include <utility>

namespace kappamu {

GradientSolution conjugate_gradients(
    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& product, const Eigen::VectorXd& b,
    int steps, const std::function<bool(const GradientStep&)>& enough) {
  GradientSolution at{Eigen::VectorXd::Zero(b.size()), b};
  Eigen::VectorXd direction = b;
  double square = b.squaredNorm();
  double energy = 0.0;
  for (int k = 0; k < steps && square > 0.0; ++k) {
    const Eigen::VectorXd image = product(direction);
    const double length = square / direction.dot(image);
    at.x += length * direction;
    at.rest -= length * image;
    const double gain = length * square;
    energy += gain;
    const double before = std::exchange(square, at.rest.squaredNorm());
    if (enough({at.x, energy, gain, std::sqrt(square)})) break;
    direction = at.rest + (square / before) * direction;
  }
  return at;
}

}  // namespace kappamu
