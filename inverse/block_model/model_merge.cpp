#include "inverse/block_model/model_merge.h"

#include <Eigen/Cholesky>
#include <optional>
#include <utility>
#include <vector>

namespace kappamu::inverse {

namespace {

struct Joint {
  double rise = 0.0;       ///< of χ²
  Eigen::VectorXd values;  ///< of all layers once l and l + 1 are equal
};

/// Least rise of χ² with layers l and l + 1 alike.
Joint join(const Eigen::VectorXd& p, const Eigen::LDLT<Eigen::MatrixXd>& normal, Eigen::Index l) {
  const Eigen::Index layers = p.size() / 2;
  Eigen::MatrixXd differences = Eigen::MatrixXd::Zero(p.size(), 2);
  for (const Eigen::Index k : {Eigen::Index{0}, Eigen::Index{1}}) {
    differences(k * layers + l, k) = 1.0;
    differences(k * layers + l + 1, k) = -1.0;
  }
  const Eigen::MatrixXd answer = normal.solve(differences);
  const Eigen::Matrix2d spread = differences.transpose() * answer;
  const Eigen::Vector2d unlike = differences.transpose() * p;
  const Eigen::Vector2d force = spread.ldlt().solve(unlike);
  return {unlike.dot(force), p - answer * force};
}

}  // namespace

LayeredMedium merge_layers(const LayeredMedium& medium, const Eigen::MatrixXd& normal,
                           double allowance) {
  std::vector<int> first = medium.first;
  Eigen::MatrixXd hessian = normal;
  Eigen::VectorXd p(normal.rows());
  p << Eigen::Map<const Eigen::VectorXd>(medium.log_kappa.data(), medium.layers()),
      Eigen::Map<const Eigen::VectorXd>(medium.log_mu.data(), medium.layers());
  while (first.size() > 1) {
    const Eigen::Index layers = p.size() / 2;
    const Eigen::LDLT<Eigen::MatrixXd> factored(hessian);
    std::optional<Joint> best;
    Eigen::Index at = 0;
    for (Eigen::Index l = 0; l + 1 < layers; ++l) {
      Joint joint = join(p, factored, l);
      if (best && best->rise <= joint.rise) continue;
      best = std::move(joint);
      at = l;
    }
    if (best->rise > allowance) break;
    allowance -= best->rise;
    // One unknown for both from here on.
    Eigen::MatrixXd copies = Eigen::MatrixXd::Zero(2 * layers, 2 * (layers - 1));
    for (Eigen::Index k = 0; k < 2 * layers; ++k) {
      const Eigen::Index half = k / layers;
      const Eigen::Index l = k % layers;
      copies(k, half * (layers - 1) + (l > at ? l - 1 : l)) = 1.0;
    }
    Eigen::VectorXd fewer(2 * (layers - 1));
    for (Eigen::Index k = 0; k < 2 * layers; ++k) {
      const Eigen::Index l = k % layers;
      if (l != at + 1) fewer[k / layers * (layers - 1) + (l > at ? l - 1 : l)] = best->values[k];
    }
    p = std::move(fewer);
    hessian = (copies.transpose() * hessian * copies).eval();
    first.erase(first.begin() + at + 1);
  }
  const Eigen::Index layers = p.size() / 2;
  return {first, std::vector<double>(p.data(), p.data() + layers),
          std::vector<double>(p.data() + layers, p.data() + 2 * layers)};
}

}  // namespace kappamu::inverse
