#include "forward/polygrid/opencl/former_answers.h"

#include <Eigen/Cholesky>

namespace kappamu::forward::polygrid {

namespace {

constexpr std::size_t most_answers = 4;
/// Of the largest product: differences of answers that drown in the rounding of float.
constexpr double ridge = 1e-7;

}  // namespace

FormerAnswers::FormerAnswers(device::Context& context, std::size_t bytes)
    : context_(context), kept_(most_answers), bytes_(bytes) {
  for (Kept& kept : kept_) {
    kept.answer = context.allocate(bytes);
    kept.image = context.allocate(bytes);
    kept.products.resize(most_answers);
  }
}

std::vector<Scalars> FormerAnswers::combination(const device::Buffer& load, const Dot& dot) const {
  std::vector<Scalars> right, result(size_);
  for (std::size_t k = 0; k < size_; ++k) right.push_back(dot(load, image(k)));
  const auto n = static_cast<Eigen::Index>(size_);
  for (std::size_t lane = 0; size_ > 0 && lane < right[0].size(); ++lane) {
    Eigen::MatrixXd products(n, n);
    Eigen::VectorXd with_load(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto row = static_cast<std::size_t>(i);
      with_load[i] = right[row][lane];
      for (Eigen::Index j = 0; j < n; ++j) {
        products(i, j) = kept_[row].products[static_cast<std::size_t>(j)][lane];
      }
    }
    const double largest = products.diagonal().maxCoeff();
    products.diagonal().array() += ridge * largest;
    const Eigen::VectorXd times = largest > 0.0 ? Eigen::VectorXd(products.ldlt().solve(with_load))
                                                : Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i) result[static_cast<std::size_t>(i)].push_back(times[i]);
  }
  return result;
}

void FormerAnswers::keep(const device::Buffer& answer, const device::Buffer& image,
                         const Dot& dot) {
  if (size_ == 0) oldest_ = 0;
  const std::size_t at = size_ < most_answers ? size_++ : oldest_;
  oldest_ = (at + 1) % most_answers;
  context_.copy(answer, kept_[at].answer, bytes_);
  context_.copy(image, kept_[at].image, bytes_);
  for (std::size_t k = 0; k < size_; ++k) {
    kept_[at].products[k] = kept_[k].products[at] = dot(kept_[at].image, kept_[k].image);
  }
}

}  // namespace kappamu::forward::polygrid
