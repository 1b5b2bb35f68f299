#include "io/volume/volume_file.h"

#include <cmath>
#include <limits>
#include <random>

#include "tests/io/python.h"
#include "tests/io/support.h"
#include "tests/io/volume/marker_volume.h"

namespace kappamu::io {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

using VolumeFile = FolderTest;
using VolumeFolder = FolderTest;

/// Storage is 32-bit float: half a unit in the last place.
constexpr double float_rounding = 0.5 * std::numeric_limits<float>::epsilon();

void expect_same(const Volume<double>& a, const Volume<double>& b) {
  ASSERT_EQ(a.shape(), b.shape());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_LE(std::abs(a[i] - b[i]), float_rounding * std::abs(b[i])) << "voxel " << i;
  }
}

void expect_same(const VolumeSet& a, const VolumeSet& b) {
  EXPECT_EQ(a.channels, b.channels);
  EXPECT_EQ(a.eta, b.eta);
  EXPECT_EQ(a.metadata, b.metadata);
  ASSERT_EQ(a.media.size(), b.media.size());
  for (std::size_t c = 0; c < a.media.size(); ++c) {
    expect_same(a.media[c].kappa, b.media[c].kappa);
    expect_same(a.media[c].mu, b.media[c].mu);
  }
  const auto all = [](const auto& x, const auto& y) {
    ASSERT_EQ(x.size(), y.size());
    for (std::size_t c = 0; c < x.size(); ++c) expect_same(x[c], y[c]);
  };
  all(a.kappa_std, b.kappa_std);
  all(a.mu_std, b.mu_std);
  all(a.kappa_resolution, b.kappa_resolution);
  all(a.mu_resolution, b.mu_resolution);
  all(a.sensitivity, b.sensitivity);
}

VolumeSet full_set() {
  VolumeSet set = marker_set();
  for (int c = 0; c < 2; ++c) {
    set.kappa_std.push_back(with_marker(0.01, 0.02, c, 0, 1));
    set.mu_std.push_back(with_marker(0.0, 0.003, c, 1, 1));
    set.kappa_resolution.push_back(with_marker(0.5, 0.9, c, 1, 2));
    set.mu_resolution.push_back(with_marker(0.25, 0.0, c, 0, 2));
    set.sensitivity.push_back(with_marker(1.0, 7.0, c, 2, 1));
  }
  return set;
}

TEST_F(VolumeFile, AnyVolumesOfOneGridAreWrittenWhereASetsLie) {
  const VolumeSet set = marker_set();
  write_vdb(folder_ / "set.vdb", set);
  std::vector<NamedVolume> volumes = named_volumes(set);
  write_vdb(folder_ / "volumes.vdb", volumes);
  const VolumeSet back = read_vdb(folder_ / "volumes.vdb");
  const VolumeSet expected = read_vdb(folder_ / "set.vdb");
  ASSERT_EQ(back.channels, expected.channels);
  for (std::size_t c = 0; c < back.media.size(); ++c) {
    expect_same(back.media[c].kappa, expected.media[c].kappa);
    expect_same(back.media[c].mu, expected.media[c].mu);
  }
}

VolumeSet random_set(const GridShape& shape, std::vector<std::string> channels) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0.01, 1.0);
  VolumeSet set;
  set.channels = std::move(channels);
  for (std::size_t c = 0; c < set.channels.size(); ++c) {
    Medium medium{Volume<double>(shape), Volume<double>(shape)};
    for (double& value : medium.kappa.values()) value = uniform(random);
    for (double& value : medium.mu.values()) value = uniform(random);
    set.media.push_back(medium);
  }
  return set;
}

TEST_F(VolumeFile, EverythingComesBack) {
  for (const VolumeSet& set :
       {marker_set(), full_set(), random_set({1, 1, 1, 3.0}, {"grey"}),
        random_set({17, 1, 9, 0.1}, {"R", "G", "B"}), random_set({8, 16, 24, 1e-3}, {"b", "a"})}) {
    write_vdb(folder_ / "a.vdb", set);
    expect_same(read_vdb(folder_ / "a.vdb"), set);
    expect_same(read_volume(folder_ / "a.vdb"), set);
    write_volume_folder(folder_ / "a", set);
    expect_same(read_volume(folder_ / "a"), set);
  }
}

TEST_F(VolumeFile, SameVolumeGivesSameBytes) {
  write_vdb(folder_ / "a.vdb", full_set());
  write_vdb(folder_ / "b.vdb", full_set());
  write_vdb(folder_ / "c.vdb", marker_set());
  const auto content = [&](const char* name) { return read_text(folder_ / name); };
  EXPECT_EQ(content("a.vdb"), content("b.vdb"));
  EXPECT_NE(content("a.vdb"), content("c.vdb"));
}

TEST_F(VolumeFile, OpenVdbFindsTheMarkerWhereItIs) {
  KAPPAMU_NEED_PYTHON("pyopenvdb");
  VolumeSet set = marker_set();
  set.media[0].mu = with_marker(0.0, 0.02, 4, 1, 2);
  set.media[1].mu = with_marker(0.0, 0.03, 0, 2, 3);
  set.media[1].kappa = with_marker(0.1, 0.4, 4, 1, 2);
  set.media[1].mu = with_marker(0.0, 0.03, 4, 1, 2);
  write_vdb(folder_ / "a.vdb", set);
  EXPECT_EQ(run_script("read_volumes.py", "vdb " + (folder_ / "a.vdb").string()),
            "albedo_G [1] 5x3x4 at 1.1250 0.3750 0.6250 is 0.964 in 1\n"
            "albedo_R [1] 5x3x4 at 1.1250 0.3750 0.6250 is 0.97 in 1\n"
            "density [1/mm] 5x3x4 at 1.1250 0.3750 0.6250 is 0.75 in 2.5\n"
            "kappa_G [mm] 5x3x4 at 1.1250 0.3750 0.6250 is 0.4 in 0.1\n"
            "kappa_R [mm] 5x3x4 at 1.1250 0.3750 0.6250 is 0.5 in 0.2\n"
            "mu_G [1/mm] 5x3x4 at 1.1250 0.3750 0.6250 is 0.03 in 0\n"
            "mu_R [1/mm] 5x3x4 at 1.1250 0.3750 0.6250 is 0.02 in 0\n"
            "sigma_t_G [1/mm] 5x3x4 at 1.1250 0.3750 0.6250 is 0.83333 in 3.3333\n"
            "sigma_t_R [1/mm] 5x3x4 at 1.1250 0.3750 0.6250 is 0.66667 in 1.6667\n"
            "eta 1.45 session demo <a&b>\n");
}

/// For shaders that take all channels at once.
TEST_F(VolumeFile, RedGreenAndBlueComeAsVectorGridsToo) {
  KAPPAMU_NEED_PYTHON("pyopenvdb");
  VolumeSet set;
  const GridShape shape{2, 2, 2, 0.5};
  set.channels = {"R", "G", "B"};
  for (const double kappa : {0.5, 0.25, 0.125}) {
    set.media.push_back({Volume<double>(shape, kappa), Volume<double>(shape, 0.1)});
  }
  write_vdb(folder_ / "rgb.vdb", set);
  EXPECT_EQ(run_python("import pyopenvdb as v\n"
                       "for name in ('sigma_t', 'color'):\n"
                       "  print(*('%.4f' % x for x in v.read('rgb.vdb', "
                       "name).getConstAccessor().getValue((1, 0, 1))))",
                       folder_),
            "0.6667 1.3333 2.6667\n0.8500 0.9250 0.9625\n");
  EXPECT_THAT(read_vdb(folder_ / "rgb.vdb").channels, ElementsAre("R", "G", "B"));
}

TEST_F(VolumeFile, VdbOfAnotherProgramIsRead) {
  KAPPAMU_NEED_PYTHON("pyopenvdb");
  run_python(
      "import numpy as n, pyopenvdb as v\n"
      "def grid(name, value, shape, scale=0.5):\n"
      "  g = v.FloatGrid(); g.name = name; g.transform = v.createLinearTransform(scale)\n"
      "  g.copyFromArray(n.full(shape, value, 'f4'), ijk=(2, -3, 7)); return g\n"
      "s = (3, 2, 4)\n"
      "v.write('good.vdb', grids=[grid('kappa', 0.3, s), grid('mu', 0.1, s)])\n"
      "v.write('alone.vdb', grids=[grid('kappa_R', 0.3, s)])\n"
      "v.write('other.vdb', grids=[grid('density', 0.3, s)])\n"
      "v.write('large.vdb', grids=[grid('kappa', 0.3, s), grid('mu', 0.1, (3, 2, 5))])\n"
      "v.write('scale.vdb', grids=[grid('kappa', 0.3, s), grid('mu', 0.1, s, 0.4)])\n"
      "g = grid('kappa', 0.3, s); g.getAccessor().setValueOn((3, -3, 7), float('nan'))\n"
      "v.write('nan.vdb', grids=[g, grid('mu', 0.1, s)])\n"
      "v.write('minus.vdb', grids=[grid('kappa', -0.3, s), grid('mu', 0.1, s)])\n"
      "g = grid('kappa', 0.3, s); g.getAccessor().setValueOn((10**6, 0, 0), 1.0)\n"
      "v.write('stray.vdb', grids=[g, grid('mu', 0.1, s)])\n",
      folder_);
  const VolumeSet set = read_vdb(folder_ / "good.vdb");
  EXPECT_THAT(set.channels, ElementsAre("grey"));
  EXPECT_EQ(set.shape(), (GridShape{3, 2, 4, 0.5}));
  EXPECT_FLOAT_EQ(static_cast<float>(set.media[0].kappa(2, 1, 3)), 0.3F);
  EXPECT_FALSE(set.eta.has_value());
  const auto sentence = [&](const char* name) {
    return sentence_of([&] { read_vdb(folder_ / name); });
  };
  EXPECT_THAT(sentence("alone.vdb"), HasSubstr("has grid kappa_R but no float grid mu_R"));
  EXPECT_THAT(sentence("other.vdb"), HasSubstr("no float grid named kappa or kappa_<channel>"));
  EXPECT_THAT(sentence("large.vdb"), HasSubstr("grid mu reaches beyond kappa"));
  EXPECT_THAT(sentence("scale.vdb"), HasSubstr("grid mu has another transform than kappa"));
  EXPECT_THAT(sentence("nan.vdb"),
              HasSubstr("nan.vdb, channel grey: kappa is nan at voxel x=1 y=0 z=0"));
  EXPECT_THAT(sentence("minus.vdb"), HasSubstr("channel grey: kappa is -0.3 at voxel x=0"));
  EXPECT_THAT(sentence("stray.vdb"), HasSubstr("does not fill its box"));
}

/// What follows has `k` and `m`, arrays [x][y][z], and makes grids of them.
const std::string python_grids =
    "import numpy as n, pyopenvdb as v\n"
    "s = (3, 2, 4)\n"
    "k = (0.1 + 0.01 * n.arange(24)).astype('f4').reshape(s); m = k / 10\n"
    "def grid(name, a, kind=v.FloatGrid, **options):\n"
    "  g = kind(**options); g.name = name; g.copyFromArray(a, ijk=(2, -3, 7))\n"
    "  g.transform = v.createLinearTransform(0.5); return g\n"
    "def turned(name, a, rows):\n"
    "  g = grid(name, a); g.transform = v.createLinearTransform(rows); return g\n";

/// The volume of python_grids: along x, y, z whatever the grid's own axes.
void expect_python_grids(const VolumeSet& set) {
  ASSERT_EQ(set.shape(), (GridShape{3, 2, 4, 0.5}));
  for (const Medium& medium : set.media) {
    for (int z = 0; z < 4; ++z) {
      for (int y = 0; y < 2; ++y) {
        for (int x = 0; x < 3; ++x) {
          const double kappa = 0.1 + 0.01 * ((x * 2 + y) * 4 + z);
          EXPECT_NEAR(medium.kappa(x, y, z), kappa, 1e-3 * kappa);
          EXPECT_NEAR(medium.mu(x, y, z), 0.1 * kappa, 1e-4 * kappa);
        }
      }
    }
  }
}

// OpenVDB writes a tree that grids share once.
TEST_F(VolumeFile, InstancesHaveTheirParentsValues) {
  KAPPAMU_NEED_PYTHON("pyopenvdb");
  run_python(python_grids +
                 "g = grid('kappa_R', k); h = grid('mu_R', m)\n"
                 "def copy(g, name): c = g.copy(); c.name = name; return c\n"
                 "v.write('a.vdb', grids=[copy(h, 'mu_G'), g, h, copy(g, 'kappa_G')])\n",
             folder_);
  const VolumeSet set = read_vdb(folder_ / "a.vdb");
  EXPECT_THAT(set.channels, ElementsAre("R", "G"));
  expect_python_grids(set);
}

TEST_F(VolumeFile, GridsOfOtherAxesArePermuted) {
  KAPPAMU_NEED_PYTHON("pyopenvdb");
  run_python(
      python_grids +
          // Rows are the steps of the world along each index.
          "yz = [[.5,0,0,0],[0,0,.5,0],[0,.5,0,0],[0,0,0,1]]\n"
          "f = [n.transpose(a, (0, 2, 1)).copy() for a in (k, m)]\n"
          "v.write('swap.VDB', grids=[turned('kappa', f[0], yz), turned('mu', f[1], yz)])\n"
          "mirror = [[-.5,0,0,0],[0,.5,0,0],[0,0,.5,0],[9,0,0,1]]\n"
          "f = [a[::-1].copy() for a in (k, m)]\n"
          "v.write('mirror.vdb', grids=[turned('kappa', f[0], mirror), turned('mu', f[1], "
          "mirror)])\n"
          "turn = [[0,.5,0,0],[-.5,0,0,0],[0,0,.5,0],[0,0,0,1]]\n"
          "f = [n.transpose(a[::-1], (1, 0, 2)).copy() for a in (k, m)]\n"
          "v.write('turn.vdb', grids=[turned('kappa', f[0], turn), turned('mu', f[1], turn)])\n"
          "c = .4; t = .3\n"
          "for name, rows in (('rotated', [[c,t,0,0],[-t,c,0,0],[0,0,.5,0],[0,0,0,1]]),\n"
          "    ('sheared', [[.5,.5,0,0],[0,.5,0,0],[0,0,.5,0],[0,0,0,1]]),\n"
          "    ('long', [[.5,0,0,0],[0,.6,0,0],[0,0,.5,0],[0,0,0,1]])):\n"
          "  v.write(name + '.vdb', grids=[turned('kappa', k, rows), turned('mu', m, rows)])\n"
          "g = grid('kappa', k); g.transform = v.createFrustumTransform((0,0,0),(9,9,9),.5,3)\n"
          "v.write('frustum.vdb', grids=[g, grid('mu', m)])\n",
      folder_);
  for (const char* name : {"swap.VDB", "mirror.vdb", "turn.vdb"}) {
    SCOPED_TRACE(name);
    expect_python_grids(read_volume(folder_ / name));
  }
  for (const char* name : {"rotated.vdb", "sheared.vdb", "long.vdb", "frustum.vdb"}) {
    EXPECT_THAT(sentence_of([&] { read_volume(folder_ / name); }),
                HasSubstr(std::string(name) + ": grid kappa must have cubic voxels along"));
  }
}

TEST_F(VolumeFile, OtherKindsOfGridsAreReadOrNamed) {
  KAPPAMU_NEED_PYTHON("pyopenvdb");
  run_python(
      python_grids +
          "def files(name, kappa, mu=grid('mu', m), *more):\n"
          "  v.write(name + '.vdb', grids=[kappa, mu, *more])\n"
          "g = grid('kappa', k); h = grid('mu', m)\n"
          "g.saveFloatAsHalf = h.saveFloatAsHalf = True; files('half', g, h)\n"
          "files('background', grid('kappa', k, background=5.0), grid('mu', m, background=3.0))\n"
          "files('more', grid('kappa', k), grid('mu', m), grid('density', k), grid('density', m))\n"
          "if hasattr(v, 'DoubleGrid'): files('double', grid('kappa', k.astype('f8'), "
          "v.DoubleGrid))\n"
          "files('twice', grid('kappa', k), grid('mu', m), grid('kappa', 2 * k))\n"
          "g = grid('kappa', n.stack([k, k, k], -1), v.Vec3SGrid); files('vector', g)\n"
          "g = grid('kappa', k); g.gridClass = v.GridClass.LEVEL_SET; files('level', g)\n"
          "files('empty', v.FloatGrid()); g = v.FloatGrid(); g.name = 'kappa'; files('none', g)\n"
          "files('both', grid('kappa', k), grid('mu', m), grid('kappa_R', k))\n"
          "files('lost', grid('kappa_R', k), grid('mu_R', m), grid('mu_G', m))\n"
          "files('small', grid('kappa_R', k), grid('mu_R', m), grid('kappa_G', k[:2]), "
          "grid('mu_G', m))\n",
      folder_);
  for (const char* name : {"half.vdb", "background.vdb", "more.vdb", "double.vdb"}) {
    SCOPED_TRACE(name);
    if (std::filesystem::exists(folder_ / name)) expect_python_grids(read_vdb(folder_ / name));
  }
  const auto sentence = [&](const char* name) {
    return sentence_of([&] { read_vdb(folder_ / name); });
  };
  EXPECT_THAT(sentence("twice.vdb"), HasSubstr("twice.vdb: has two grids named kappa; leave one"));
  EXPECT_THAT(sentence("vector.vdb"),
              HasSubstr("grid kappa is of type vec3s; write it as a float"));
  EXPECT_THAT(sentence("level.vdb"), HasSubstr("grid kappa is a level set"));
  EXPECT_THAT(sentence("empty.vdb"), HasSubstr("its grids are , mu"));
  EXPECT_THAT(sentence("none.vdb"), HasSubstr("grid kappa has no active voxels"));
  EXPECT_THAT(sentence("both.vdb"), HasSubstr("has grids kappa and kappa_R; leave one"));
  EXPECT_THAT(sentence("lost.vdb"), HasSubstr("has grid mu_G but no float grid kappa_G"));
  EXPECT_THAT(sentence("small.vdb"), HasSubstr("grid kappa_G does not fill its box"));
}

TEST_F(VolumeFile, TruncatedFilesAreRefused) {
  write_vdb(folder_ / "a.vdb", random_set({17, 9, 11, 0.1}, {"R", "G", "B"}));
  expect_truncations_are_refused(folder_ / "a.vdb", [](const auto& file) { read_vdb(file); });
  write_text_atomically(folder_ / "a.vdb", "this is no volume, it is a letter to a friend");
  EXPECT_EQ(sentence_of([&] { read_volume(folder_ / "a.vdb"); }),
            (folder_ / "a.vdb").string() + ": not a complete OpenVDB file; write or copy it again");
}

TEST_F(VolumeFile, BadVolumesAreNotWritten) {
  VolumeSet set = marker_set();
  set.media[1].kappa(4, 2, 3) = std::nan("");
  EXPECT_EQ(sentence_of([&] { write_vdb(folder_ / "a.vdb", set); }),
            (folder_ / "a.vdb").string() +
                ", channel G: kappa is nan at voxel x=4 y=2 z=3; every kappa must be positive, "
                "from 1e-9 to 1e9 mm");
  set = marker_set();
  set.channels[1] = "R";
  EXPECT_THAT(sentence_of([&] { write_vdb(folder_ / "a.vdb", set); }),
              HasSubstr("channel 'R' is there twice"));
  set.channels[1] = "a/b";
  EXPECT_THAT(sentence_of([&] { write_vdb(folder_ / "a.vdb", set); }),
              HasSubstr("a channel's name is 'a/b'; use letters"));
  set = full_set();
  set.mu_std.pop_back();
  EXPECT_THAT(sentence_of([&] { write_vdb(folder_ / "a.vdb", set); }),
              HasSubstr("standard deviation of mu is not given for each channel"));
  EXPECT_THAT(listing(), testing::IsEmpty());
}

TEST_F(VolumeFolder, LeftoversOfAnOlderVolumeAreIgnored) {
  write_volume_folder(folder_, full_set());
  write_volume_folder(folder_, marker_set());
  EXPECT_TRUE(read_volume(folder_).kappa_std.empty());
  EXPECT_TRUE(read_volume(folder_).mu_resolution.empty());
}

TEST_F(VolumeFolder, WrongFieldsAndArraysAreNamed) {
  write_volume_folder(folder_, marker_set());
  std::filesystem::remove(folder_ / "mu_G.npy");
  EXPECT_THAT(sentence_of([&] { read_volume(folder_); }),
              HasSubstr("mu_G.npy: there is no such file"));
  std::string text = read_text(folder_ / "volume.json");
  text.replace(text.find("0.25"), 4, "-1.0");
  write_text_atomically(folder_ / "volume.json", text);
  EXPECT_THAT(sentence_of([&] { read_volume(folder_); }),
              HasSubstr("volume.json: voxel_mm must be positive"));
  std::filesystem::remove(folder_ / "volume.json");
  EXPECT_THAT(sentence_of([&] { read_volume(folder_); }),
              HasSubstr("volume.json: there is no such file"));
  EXPECT_THAT(sentence_of([&] { read_volume(folder_ / "none"); }),
              HasSubstr("there is no such file or folder"));
}

}  // namespace
}  // namespace kappamu::io
