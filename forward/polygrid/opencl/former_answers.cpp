#include "forward/polygrid/opencl/former_answers.h"

#include "core/numbers/linear_algebra.h"

namespace kappamu::forward::polygrid {

namespace {

/// Of the largest product: differences of answers that drown in the rounding of float.
constexpr double ridge = 1e-7;

}  // namespace

FormerAnswers::FormerAnswers(device::Context& context, std::size_t bytes) {
  for (Kept& kept : kept_) {
    kept.answer = context.allocate(bytes);
    kept.image = context.allocate(bytes);
  }
}

FormerAnswers::OfEach FormerAnswers::combination(const OfEach& with_load) const {
  OfEach result;
  const auto n = static_cast<Eigen::Index>(size_);
  for (Scalars& times : result) times.resize(with_load[0].size(), 0.0);
  for (std::size_t lane = 0; lane < with_load[0].size(); ++lane) {
    Eigen::MatrixXd products(n, n);
    Eigen::VectorXd right(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto row = static_cast<std::size_t>(i);
      right[i] = with_load[row][lane];
      for (Eigen::Index j = 0; j < n; ++j) {
        products(i, j) = kept_[row].products[static_cast<std::size_t>(j)][lane];
      }
    }
    const double largest = products.diagonal().maxCoeff();
    if (!(largest > 0.0)) continue;
    products.diagonal().array() += ridge * largest;
    const Eigen::VectorXd times = solve_symmetric(products, right);
    for (Eigen::Index i = 0; i < n; ++i) result[static_cast<std::size_t>(i)][lane] = times[i];
  }
  return result;
}

FormerAnswers::Kept& FormerAnswers::next() {
  last_ = size_ == 0 ? 0 : (last_ + 1) % most;
  if (size_ < most) ++size_;
  return kept_[last_];
}

void FormerAnswers::set_products(const Scalars& with_itself, const OfEach& with_others) {
  for (std::size_t k = 0; k < size_; ++k) {
    kept_[last_].products[k] = kept_[k].products[last_] = k == last_ ? with_itself : with_others[k];
  }
}

}  // namespace kappamu::forward::polygrid
