#include "io/volume/npy_volume.h"

#include "io/npy.h"
#include "tests/io/support.h"

namespace kappamu::io {
namespace {

using testing::HasSubstr;

using NpyVolume = FolderTest;

TEST_F(NpyVolume, ComesBackWithXFastest) {
  Volume<double> volume(GridShape{5, 3, 2, 0.5});
  for (std::size_t i = 0; i < volume.size(); ++i) volume[i] = 0.25 * static_cast<double>(i);
  write_npy_volume(folder_ / "kappa_R.npy", volume);
  EXPECT_EQ(read_npy(folder_ / "kappa_R.npy").shape, (std::vector<std::size_t>{2, 3, 5}));
  const Volume<double> same = read_npy_volume(folder_ / "kappa_R.npy", volume.shape());
  EXPECT_EQ(same.values(), volume.values());
  const Volume<double> of_file = read_npy_volume(folder_ / "kappa_R.npy", 0.5);
  EXPECT_EQ(of_file.shape(), volume.shape());
  EXPECT_EQ(of_file(4, 2, 1), volume(4, 2, 1));
}

TEST_F(NpyVolume, OtherShapesAreRefusedByName) {
  write_npy_volume(folder_ / "mu_R.npy", Volume<double>(GridShape{5, 3, 2, 0.5}));
  const std::string other = sentence_of([&] {
    read_npy_volume(folder_ / "mu_R.npy", GridShape{5, 3, 4, 0.5});
  });
  EXPECT_THAT(other, HasSubstr("mu_R.npy"));
  EXPECT_THAT(other, HasSubstr("[2][3][5]"));
  EXPECT_THAT(other, HasSubstr("[4][3][5]"));
  write_npy(folder_ / "flat.npy", {2, 3}, std::span<const float>(std::vector<float>(6)));
  EXPECT_THAT(sentence_of([&] { read_npy_volume(folder_ / "flat.npy", 0.5); }),
              HasSubstr("is not that of a volume [z][y][x]"));
}

}  // namespace
}  // namespace kappamu::io
