// Images of light: what their codes mean.
#include "render/linear_image.h"

#include <gtest/gtest.h>

#include "io/image/image_file.h"
#include "tests/own_folder.h"

namespace kappamu::render {
namespace {

TEST(LinearImage, CodesAreOfTheFilesDepthHoweverDarkTheImage) {
  const OwnFolder folder;
  Image<std::uint16_t> dark(2, 1, 1);
  dark(0, 0) = 255;
  dark(1, 0) = 40;
  io::write_image(folder / "deep.png", dark);
  io::write_code_image(folder / "shallow.png", dark, 8);
  const Image<float> deep = read_linear_image(folder / "deep.png");
  const Image<float> shallow = read_linear_image(folder / "shallow.png");
  constexpr double rounding = 1e-6;
  EXPECT_NEAR(deep(0, 0, 0), srgb_decoded(255.0 / 65535.0), rounding);
  EXPECT_NEAR(deep(1, 0, 2), srgb_decoded(40.0 / 65535.0), rounding);
  EXPECT_NEAR(shallow(0, 0, 1), 1.0, rounding);
  EXPECT_NEAR(shallow(1, 0, 0), srgb_decoded(40.0 / 255.0), rounding);
}

}  // namespace
}  // namespace kappamu::render
