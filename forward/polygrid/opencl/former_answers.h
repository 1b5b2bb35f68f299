// The last answers of equations whose light moves. By linearity the answer to a combination of
// their loads is the same combination of them, so that the next light starts from the one of least
// residual (P. F. Fischer, Projection techniques for iterative solution of Ax = b with successive
// right-hand sides, Comput. Methods Appl. Mech. Engrg. 163, 1998).
#pragma once

#include <array>
#include <vector>

#include "device/context.h"
#include "forward/linear/conjugate_gradients.h"

namespace kappamu::forward::polygrid {

using linear::Scalars;

class FormerAnswers {
 public:
  static constexpr std::size_t most = 4;
  using OfEach = std::array<Scalars, most>;

  /// Fields of so many bytes.
  FormerAnswers(device::Context& context, std::size_t bytes);

  /// The equations have changed.
  void forget() { size_ = 0; }
  std::size_t size() const { return size_; }
  /// Those beyond size() are one that is there.
  const device::Buffer& answer(std::size_t k) const { return kept_[k < size_ ? k : 0].answer; }
  const device::Buffer& image(std::size_t k) const { return kept_[k < size_ ? k : 0].image; }

  /// What each answer is taken times for ‖load − Σ image‖ to be least, from the load's products
  /// with the images.
  OfEach combination(const OfEach& with_load) const;

  /// Room for an answer and what the matrix makes of it, in place of the oldest.
  struct Kept {
    device::Buffer answer, image;
    OfEach products;  ///< of the image with those of all others, itself included
  };
  Kept& next();
  /// Once next() is filled: its image's products with itself and with the others.
  void set_products(const Scalars& with_itself, const OfEach& with_others);

 private:
  std::array<Kept, most> kept_;
  std::size_t size_ = 0, last_ = 0;
};

}  // namespace kappamu::forward::polygrid
