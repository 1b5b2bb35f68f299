// [T] 3.6.2 and 5.3.2: what the half-space of the dipole does on shapes that are none, against
// diffusion in the shape itself (`embedded`). Energy and reciprocity, [T] 3.6.1, are in
// dipole_form_factor_test and dipole_model_test; figures against Monte Carlo in
// docs/objects-bench.md.
#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/shapes.h"
#include "forward/registry.h"
#include "tests/forward/lit_object.h"

namespace kappamu::forward {
namespace {

const Coefficients thesis_marble{0.152, 0.0021};
constexpr double thesis_eta = 1.5;
const double thesis_size = 30.0;  // [mm], 66 mean free paths; [T]: 20 to 40

/// Exitance under parallel light from above, out of the mesh's own shadow.
struct LitFromAbove {
  explicit LitFromAbove(TriangleMesh of, int axis_up)
      : mesh(std::move(of)), surface(surface_of(mesh)), up(axis_up) {
    const auto rays = embedded::make_caster(mesh);
    const Eigen::Vector3d above = Eigen::Vector3d::Unit(up);
    std::vector<ObjectLight> lights{parallel_beams(surface, -above)};
    std::erase_if(lights[0].beams, [&](const Beam& beam) {
      const Eigen::Vector3d off = 1e-6 * surface.normal[static_cast<std::size_t>(beam.triangle)];
      return rays->first_hit(beam.position + off, above, 0.0).has_value();
    });
    const ObjectMedium medium(thesis_marble);
    const ObjectProblem problem{mesh, surface, *rays, medium, thesis_eta, lights};
    Progress silent;
    ObjectOptions options;
    options.tolerance = 0.004;  // dim places count, too
    of_dipole = make_object_model("dipole-rotated")->solve(problem, options, silent).exitance;
    options.tolerance = 0.03;
    truth = make_object_model("embedded")->solve(problem, options, silent).exitance;
  }

  /// Mean of an answer over the triangles that `where` takes.
  template <class Where>
  double mean(const std::vector<double>& exitance, const Where& where) const {
    double sum = 0.0, area = 0.0;
    for (std::size_t t = 0; t < surface.size(); ++t) {
      if (!where(surface.position[t], surface.normal[t])) continue;
      sum += surface.area[t] * exitance[t];
      area += surface.area[t];
    }
    return sum / area;
  }
  /// The dipole's mean over the truth's.
  template <class Where>
  double ratio(const Where& where) const {
    return mean(of_dipole, where) / mean(truth, where);
  }

  TriangleMesh mesh;
  Surface surface;
  int up;
  std::vector<double> of_dipole, truth;
};

TEST(DipoleAsTheThesisFound, IsNearlyRightOnTheLitSideOfASphereAndFarOffOnTheOther) {
  const LitFromAbove sphere(make_shape("sphere", thesis_size, 24), 2);
  EXPECT_NEAR(sphere.ratio([](const auto& x, const auto&) { return x.z() > 5.0; }), 1.0, 0.1);
  EXPECT_LT(sphere.ratio([](const auto& x, const auto&) { return x.z() < -5.0; }), 0.6);
}

// [T] sees it too bright from either side. Below it is so at two mean free paths, and too dark from
// four on.
TEST(DipoleAsTheThesisFound, IsTooBrightOnAThinSlabAndBelowAVeryThinOne) {
  for (const bool very : {true, false}) {
    const TriangleMesh mesh = make_shape("slab", thesis_size, 24, very ? 0.03 : 0.1);
    int thin = 0;
    bounding_box(mesh).sizes().minCoeff(&thin);
    const LitFromAbove slab(mesh, thin);
    const double above = slab.ratio([&](const auto&, const auto& n) { return n[thin] > 0.5; });
    const double below = slab.ratio([&](const auto&, const auto& n) { return n[thin] < -0.5; });
    EXPECT_GT(above, very ? 1.5 : 1.1);
    if (very) {
      EXPECT_GT(below, 1.1);
    } else {
      EXPECT_LT(below, 0.9);
    }
  }
}

TEST(DipoleAsTheThesisFound, IsBrighterAtTheEdgesOfACube) {
  const LitFromAbove cube(make_shape("cube", thesis_size, 24), 2);
  const double half = 0.5 * thesis_size;
  const auto top = [](const Eigen::Vector3d& n) { return n.z() > 0.5; };
  const double edge = cube.ratio([&](const auto& x, const auto& n) {
    return top(n) && std::max(std::abs(x.x()), std::abs(x.y())) > half - 1.0;
  });
  const double middle = cube.ratio([&](const auto& x, const auto& n) {
    return top(n) && std::max(std::abs(x.x()), std::abs(x.y())) < 0.5 * half;
  });
  EXPECT_GT(edge / middle, 1.1);
}

TEST(DipoleAsTheThesisFound, SendsLightThroughAVoidAndAcrossASplit) {
  // The void's internal shadow on the underside: of diffusion, and not of the dipole.
  const auto below = [](const auto& x, const auto& n) {
    return n.z() < -0.5 && std::max(std::abs(x.x()), std::abs(x.y())) < 4.0;
  };
  const TriangleMesh outer = make_shape("cube", thesis_size, 24);
  const LitFromAbove solid(outer, 2);
  const LitFromAbove hollow(
      joined(outer, turned_inside_out(make_shape("cube", 0.6 * thesis_size, 14))), 2);
  const auto underside = [&](const LitFromAbove& object, const std::vector<double>& exitance) {
    return object.mean(exitance, [&](const auto& x, const auto& n) {
      return below(x, n) && x.z() < -0.45 * thesis_size;
    });
  };
  EXPECT_LT(underside(hollow, hollow.truth), 0.7 * underside(solid, solid.truth));
  EXPECT_NEAR(underside(hollow, hollow.of_dipole) / underside(solid, solid.of_dipole), 1.0, 0.05);

  // Halves of a cube, one above the other: the lower one is dark.
  const TriangleMesh half = box_mesh({thesis_size, thesis_size, 14.0}, 20);
  const LitFromAbove split(joined(moved(half, {0.0, 0.0, 8.0}), moved(half, {0.0, 0.0, -8.0})), 2);
  const auto lower = [](const auto& x, const auto&) { return x.z() < -0.5; };
  EXPECT_EQ(split.mean(split.truth, lower), 0.0);
  EXPECT_GT(split.mean(split.of_dipole, lower), 0.0);
}

// [T] sees the underside slightly too bright.
TEST(DipoleAsTheThesisFound, IsTooDarkBelowATorus) {
  const LitFromAbove torus(make_shape("torus", thesis_size, 24), 2);
  EXPECT_NEAR(torus.ratio([](const auto& x, const auto&) { return x.z() > 1.0; }), 1.0, 0.06);
  EXPECT_LT(torus.ratio([](const auto& x, const auto&) { return x.z() < -1.0; }), 0.85);
}

}  // namespace
}  // namespace kappamu::forward
