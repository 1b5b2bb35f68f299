#include "io/volume/volume_export.h"

#include <sstream>

#include "io/image/exr.h"
#include "tests/io/python.h"
#include "tests/io/support.h"
#include "tests/io/volume/marker_volume.h"

namespace kappamu::io {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using VolumeExport = FolderTest;

/// Derived σt' and albedo have one marker too when κ is marked and μ is zero but there.
VolumeSet single_marker_set() {
  VolumeSet set = marker_set();
  set.media[0].mu = with_marker(0.0, 0.02, 4, 1, 2);
  set.media[1].mu = with_marker(0.0, 0.03, 0, 2, 3);
  return set;
}

TEST_F(VolumeExport, VtkFindsTheMarkerWhereItIs) {
  KAPPAMU_NEED_PYTHON("vtkmodules.vtkIOXML");
  const ExportResult result = export_vti(folder_ / "a.vti", single_marker_set());
  EXPECT_THAT(result.files, ElementsAre(folder_ / "a.vti"));
  EXPECT_THAT(result.warnings, IsEmpty());
  EXPECT_EQ(run_script("read_volumes.py", "vti " + result.files[0].string()),
            "kappa_R 5x3x4 at 1.1250 0.3750 0.6250 is 0.5 in 0.2\n"
            "mu_R 5x3x4 at 1.1250 0.3750 0.6250 is 0.02 in 0\n"
            "kappa_G 5x3x4 at 0.1250 0.6250 0.8750 is 0.4 in 0.1\n"
            "mu_G 5x3x4 at 0.1250 0.6250 0.8750 is 0.03 in 0\n"
            "sigma_t_R 5x3x4 at 1.1250 0.3750 0.6250 is 0.66667 in 1.6667\n"
            "albedo_R 5x3x4 at 1.1250 0.3750 0.6250 is 0.97 in 1\n"
            "sigma_t_G 5x3x4 at 0.1250 0.6250 0.8750 is 0.83333 in 3.3333\n"
            "albedo_G 5x3x4 at 0.1250 0.6250 0.8750 is 0.964 in 1\n"
            "eta 1.45 session demo <a&b>\n");
}

/// The uncertainty of a volume as every program but ours finds it.
VolumeSet uncertain_set() {
  VolumeSet set = single_marker_set();
  for (int c = 0; c < 2; ++c) {
    set.kappa_std.push_back(with_marker(0.01, 0.02, c, 0, 1));
    set.mu_std.push_back(with_marker(0.001, 0.003, c, 1, 1));
    set.kappa_resolution.push_back(with_marker(0.5, 0.9, c, 1, 2));
    set.mu_resolution.push_back(with_marker(0.25, 0.1, c, 0, 2));
  }
  return set;
}

TEST_F(VolumeExport, VtkFindsTheStandardDeviations) {
  KAPPAMU_NEED_PYTHON("vtkmodules.vtkIOXML");
  const ExportResult result = export_vti(folder_ / "a.vti", uncertain_set());
  const std::string lines = run_script("read_volumes.py", "vti " + result.files[0].string());
  EXPECT_THAT(lines, HasSubstr("std_kappa_R 5x3x4 at 0.1250 0.1250 0.3750 is 0.02 in 0.01\n"));
  EXPECT_THAT(lines, HasSubstr("std_mu_G 5x3x4 at 0.3750 0.3750 0.3750 is 0.003 in 0.001\n"));
  EXPECT_THAT(lines, HasSubstr("resolution_kappa_R 5x3x4 at 0.1250 0.3750 0.6250 is 0.9 in 0.5\n"));
  EXPECT_THAT(lines, HasSubstr("resolution_mu_G 5x3x4 at 0.3750 0.1250 0.6250 is 0.1 in 0.25\n"));
}

TEST_F(VolumeExport, OpenVdbAndNumPyFindTheStandardDeviationsAndTheirUnits) {
  KAPPAMU_NEED_PYTHON("numpy");
  export_npy(folder_, uncertain_set());
  const auto path = [&](const char* name) {
    return std::string(" ").append((folder_ / name).string());
  };
  const std::string lines =
      run_script("read_volumes.py", "npy" + path("std_kappa_G.npy") + path("std_mu_R.npy") +
                                        path("resolution_mu_R.npy"));
  EXPECT_EQ(lines,
            "std_kappa_G [mm] 5x3x4 at 0.3750 0.1250 0.3750 is 0.02 in 0.01\n"
            "std_mu_R [1/mm] 5x3x4 at 0.1250 0.3750 0.3750 is 0.003 in 0.001\n"
            "resolution_mu_R [1] 5x3x4 at 0.1250 0.1250 0.6250 is 0.1 in 0.25\n");
  KAPPAMU_NEED_PYTHON("pyopenvdb");
  export_vdb(folder_ / "a.vdb", uncertain_set());
  EXPECT_THAT(run_script("read_volumes.py", "vdb " + (folder_ / "a.vdb").string()),
              HasSubstr("std_mu_R [1/mm] 5x3x4 at 0.1250 0.3750 0.3750 is 0.003 in 0.001\n"));
}

TEST_F(VolumeExport, NumPyFindsTheMarkerWhereItIs) {
  KAPPAMU_NEED_PYTHON("numpy");
  const ExportResult result = export_npy(folder_, marker_set());
  std::string files;
  for (const auto& file : result.files) {
    EXPECT_TRUE(std::filesystem::exists(file));
    if (file.extension() == ".npy") files.append(" ").append(file.string());
  }
  EXPECT_EQ(run_script("read_volumes.py", "npy" + files),
            "kappa_R [mm] 5x3x4 at 1.1250 0.3750 0.6250 is 0.5 in 0.2\n"
            "mu_R [1/mm] 5x3x4 at 0.3750 0.1250 0.8750 is 0.02 in 0.01\n"
            "kappa_G [mm] 5x3x4 at 0.1250 0.6250 0.8750 is 0.4 in 0.1\n"
            "mu_G [1/mm] 5x3x4 at 0.8750 0.3750 0.1250 is 0.03 in 0\n");
}

TEST_F(VolumeExport, MitsubaVolumesFollowTheFormatByteByByte) {
  KAPPAMU_NEED_PYTHON("numpy");
  VolumeSet set = single_marker_set();
  set.channels.emplace_back("B");
  set.media.push_back({with_marker(0.3, 0.6, 2, 2, 1), with_marker(0.0, 0.1, 2, 2, 1)});
  const ExportResult result = export_mitsuba(folder_, set);
  EXPECT_THAT(result.warnings, IsEmpty());
  const auto path = [&](const char* name) {
    return std::string(" ").append((folder_ / name).string());
  };
  EXPECT_EQ(run_script("read_volumes.py", "vol" + path("sigma_t.vol") + path("albedo.vol") +
                                              path("sigma_t_G.vol") + path("albedo_B.vol")),
            "sigma_t.vol 0 5x3x4 at 1.1250 0.3750 0.6250 is 0.66667 in 1.6667\n"
            "sigma_t.vol 1 5x3x4 at 0.1250 0.6250 0.8750 is 0.83333 in 3.3333\n"
            "sigma_t.vol 2 5x3x4 at 0.6250 0.6250 0.3750 is 0.55556 in 1.1111\n"
            "albedo.vol 0 5x3x4 at 1.1250 0.3750 0.6250 is 0.97 in 1\n"
            "albedo.vol 1 5x3x4 at 0.1250 0.6250 0.8750 is 0.964 in 1\n"
            "albedo.vol 2 5x3x4 at 0.6250 0.6250 0.3750 is 0.82 in 1\n"
            "sigma_t_G.vol 0 5x3x4 at 0.1250 0.6250 0.8750 is 0.83333 in 3.3333\n"
            "albedo_B.vol 0 5x3x4 at 0.6250 0.6250 0.3750 is 0.82 in 1\n");
}

TEST_F(VolumeExport, PbrtMediumHasTheMarkersWhereTheyAre) {
  VolumeSet set = marker_set();
  set.channels.emplace_back("B");
  set.media.push_back({with_marker(0.3, 0.6, 2, 2, 1), with_marker(0.0, 2.0, 0, 1, 1)});
  const ExportResult result = export_pbrt(folder_ / "medium.pbrt", set);
  EXPECT_THAT(result.warnings, ElementsAre(HasSubstr("channel B: 1 of 60 voxels")));
  const std::string text = read_text(folder_ / "medium.pbrt");
  EXPECT_THAT(text, HasSubstr("\"integer nx\" 5 \"integer ny\" 3 \"integer nz\" 4"));
  EXPECT_THAT(text, HasSubstr("\"point3 p1\" [ 1.25 0.75 1 ]"));
  const auto numbers = [&](const std::string& name) {
    std::istringstream list(text.substr(text.find('[', text.find(name)) + 1));
    std::vector<double> values;
    for (double value = 0.0; list >> value;) values.push_back(value);
    return values;
  };
  const std::vector<double> sigma_a = numbers("rgb sigma_a");
  const std::vector<double> sigma_s = numbers("rgb sigma_s");
  ASSERT_EQ(sigma_a.size(), 3U * 60);
  ASSERT_EQ(sigma_s.size(), 3U * 60);
  const GridShape& shape = set.shape();
  for (std::size_t c = 0; c < 3; ++c) {
    for (int z = 0; z < shape.nz; ++z) {
      for (int y = 0; y < shape.ny; ++y) {
        for (int x = 0; x < shape.nx; ++x) {
          const std::size_t at = 3 * ((static_cast<std::size_t>(z) * 3 + y) * 5 + x) + c;
          const double sigma_t = 1.0 / (3.0 * set.media[c].kappa(x, y, z));
          const double mu = std::min(set.media[c].mu(x, y, z), sigma_t);  // clamped beyond
          EXPECT_NEAR(sigma_a[at], mu, 1e-6);
          EXPECT_NEAR(sigma_s[at], sigma_t - mu, 1e-6);
        }
      }
    }
  }
}

TEST_F(VolumeExport, MitsubaSceneNamesItsVolumesAndUnit) {
  VolumeSet set = marker_set();
  ExportResult result = export_mitsuba(folder_ / "two", set);
  std::string scene = read_text(folder_ / "two" / "scene.xml");
  EXPECT_THAT(scene, HasSubstr("value=\"sigma_t_R.vol\""));  // two channels cannot go together
  EXPECT_THAT(scene, HasSubstr("use_grid_bbox\" value=\"true\""));
  EXPECT_THAT(scene, HasSubstr("raw\" value=\"true\""));
  EXPECT_THAT(scene, HasSubstr("Scene unit: mm"));
  EXPECT_THAT(scene, HasSubstr("emitter type=\"area\""));
  EXPECT_THAT(scene, HasSubstr("int_ior\" value=\"1.45\""));
  EXPECT_THAT(result.warnings, ElementsAre(HasSubstr("scene.xml shows channel R alone")));

  set.channels = {"grey"};
  set.media.pop_back();
  set.eta.reset();
  result = export_mitsuba(folder_ / "one", set);
  scene = read_text(folder_ / "one" / "scene.xml");
  EXPECT_THAT(scene, HasSubstr("value=\"sigma_t.vol\""));
  EXPECT_THAT(scene, testing::Not(HasSubstr("int_ior")));
  EXPECT_THAT(result.warnings, ElementsAre(HasSubstr("does not say its refractive index")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "one" / "sigma_t_grey.vol"));
}

TEST_F(VolumeExport, VoxelsWithoutScatteringAreCounted) {
  VolumeSet set = marker_set();
  set.media[1].mu(3, 1, 0) = 1.0 / (3.0 * 0.1);  // 3κμ = 1
  set.media[1].mu(2, 1, 0) = 50.0;
  set.media[1].mu(1, 1, 0) = 3.3;  // just below
  const ScatteringVolumes scattering = scattering_volumes(set.media[1]);
  EXPECT_EQ(scattering.clamped, 2U);
  EXPECT_EQ(scattering.albedo(2, 1, 0), 0.0);
  EXPECT_NEAR(scattering.albedo(1, 1, 0), 0.01, 1e-12);
  const ExportResult result = export_vti(folder_ / "a.vti", set);
  EXPECT_THAT(result.warnings,
              ElementsAre("channel G: 2 of 60 voxels have 3 kappa mu >= 1, where no scattering is "
                          "left; their albedo was set to 0"));
}

/// σa = σt'(1 − albedo) = μ: what a renderer absorbs is what we meant.
TEST_F(VolumeExport, ScatteringCoefficientsKeepTheAbsorption) {
  for (const Medium& medium : marker_set().media) {
    const ScatteringVolumes s = scattering_volumes(medium);
    for (std::size_t i = 0; i < s.albedo.size(); ++i) {
      // Rounding of 1 − albedo, times σt' of at most 4.
      EXPECT_NEAR(s.sigma_t[i] * (1.0 - s.albedo[i]), medium.mu[i], 1e-15);
    }
  }
}

TEST_F(VolumeExport, SlicesCarryTheLayers) {
  const ExportResult result = export_slices(folder_, marker_set());
  ASSERT_EQ(result.files.size(), 4U);
  const ExrImage slice = read_exr(folder_ / "slice_002.exr");
  EXPECT_EQ(slice.width, 5);
  EXPECT_EQ(slice.height, 3);
  EXPECT_EQ(slice.channels.size(), 4U);
  EXPECT_EQ(slice.channels.at("kappa.R")[1 * 5 + 4], 0.5F);
  EXPECT_EQ(slice.channels.at("kappa.R")[1 * 5 + 3], 0.2F);
  EXPECT_EQ(slice.channels.at("mu.G")[0], 0.0F);
  EXPECT_EQ(slice.attributes.at("z"), "0.625000 mm");
}

TEST_F(VolumeExport, BadVolumesAreNotExported) {
  VolumeSet set = marker_set();
  set.media[0].mu(0, 0, 1) = -1.0;
  const auto expect_refused = [&](const auto& act) {
    EXPECT_THAT(sentence_of(act), HasSubstr("channel R: mu is -1 at voxel x=0 y=0 z=1"));
  };
  expect_refused([&] { export_vti(folder_ / "a.vti", set); });
  expect_refused([&] { export_npy(folder_, set); });
  expect_refused([&] { export_mitsuba(folder_, set); });
  expect_refused([&] { export_slices(folder_, set); });
  expect_refused([&] { export_vdb(folder_ / "a.vdb", set); });
  EXPECT_THAT(listing(), IsEmpty());
}

}  // namespace
}  // namespace kappamu::io
