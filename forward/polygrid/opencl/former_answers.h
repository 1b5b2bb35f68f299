// The last answers of equations whose light moves. By linearity the answer to a combination of
// their loads is the same combination of them, so that the next light starts from the one of least
// residual (P. F. Fischer, Projection techniques for iterative solution of Ax = b with successive
// right-hand sides, Comput. Methods Appl. Mech. Engrg. 163, 1998).
#pragma once

#include <functional>
#include <vector>

#include "device/context.h"

namespace kappamu::forward::polygrid {

using Scalars = std::vector<double>;  ///< [lane]

class FormerAnswers {
 public:
  /// Dot products of two fields.
  using Dot = std::function<Scalars(const device::Buffer&, const device::Buffer&)>;

  /// Fields of so many bytes.
  FormerAnswers(device::Context& context, std::size_t bytes);

  /// The equations have changed.
  void forget() { size_ = 0; }
  std::size_t size() const { return size_; }
  const device::Buffer& answer(std::size_t k) const { return kept_[k].answer; }
  const device::Buffer& image(std::size_t k) const { return kept_[k].image; }

  /// What each answer is taken times for ‖load − Σ image‖ to be least: [answer][lane].
  std::vector<Scalars> combination(const device::Buffer& load, const Dot& dot) const;
  /// Copies an answer and what the matrix makes of it, in place of the oldest.
  void keep(const device::Buffer& answer, const device::Buffer& image, const Dot& dot);

 private:
  struct Kept {
    device::Buffer answer, image;
    std::vector<Scalars> products;  ///< of the image with those of all others, [other][lane]
  };
  device::Context& context_;
  std::vector<Kept> kept_;
  std::size_t bytes_, size_ = 0, oldest_ = 0;
};

}  // namespace kappamu::forward::polygrid
