// Images of light: what their codes mean.
#include "render/linear_image.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <stdexcept>
#include <string>

#include "io/image/image_file.h"

namespace kappamu::render {
namespace {

namespace fs = std::filesystem;

class LinearImage : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "kappamu-light-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
};

TEST_F(LinearImage, CodesAreOfTheFilesDepthHoweverDarkTheImage) {
  Image<std::uint16_t> dark(2, 1, 1);
  dark(0, 0) = 255;
  dark(1, 0) = 40;
  io::write_image(folder_ / "deep.png", dark);
  io::write_code_image(folder_ / "shallow.png", dark, 8);
  const Image<float> deep = read_linear_image(folder_ / "deep.png");
  const Image<float> shallow = read_linear_image(folder_ / "shallow.png");
  constexpr double rounding = 1e-6;
  EXPECT_NEAR(deep(0, 0, 0), srgb_decoded(255.0 / 65535.0), rounding);
  EXPECT_NEAR(deep(1, 0, 2), srgb_decoded(40.0 / 65535.0), rounding);
  EXPECT_NEAR(shallow(0, 0, 1), 1.0, rounding);
  EXPECT_NEAR(shallow(1, 0, 0), srgb_decoded(40.0 / 255.0), rounding);
}

}  // namespace
}  // namespace kappamu::render
