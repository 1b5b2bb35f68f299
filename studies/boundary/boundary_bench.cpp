// Integral equations on surfaces, with the exact solution u = e^(λ d·x) prescribed: its q at the
// panels is the light, so that any mesh has a known answer and no facets' error.
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/mesh/shapes.h"
#include "core/processor_time.h"
#include "forward/boundary_integral/boundary_solve.h"
#include "forward/light_entry.h"
#include "io/npy.h"
#include "studies/subjects.h"

namespace kappamu::studies {

namespace {

using namespace forward;
using namespace forward::boundary_integral;

constexpr double size_mm = 10.0, eta = 1.3;
const Coefficients medium{0.2, 0.02};
/// Of sums and residuals; and of the solution that shows what these leave.
constexpr double accuracy = 1e-5, closer = 1e-6;

struct Case {
  std::string shape;
  int tessellation = 0;
};

/// Beams, which would ask for rays, are not measured here.
class NoRays : public RayCaster {
 public:
  std::optional<RayHit> first_hit(const Eigen::Vector3d&, const Eigen::Vector3d&, double,
                                  double) const override {
    return std::nullopt;
  }
};

/// u and u + 2Aκ ∂u/∂n at a panel's centroid.
struct Prescribed {
  Eigen::VectorXd fluence, q;
};

Prescribed prescribed(const Surface& surface, const BoundaryConstants& constants) {
  const double decay = std::sqrt(medium.mu / medium.kappa);
  const Eigen::Vector3d along = Eigen::Vector3d(1.0, 2.0, 3.0).normalized();
  const auto count = static_cast<Eigen::Index>(surface.size());
  Prescribed result{Eigen::VectorXd(count), Eigen::VectorXd(count)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto t = static_cast<std::size_t>(k);
    const double u = std::exp(decay * along.dot(surface.position[t]));
    result.fluence[k] = u;
    result.q[k] =
        u * (1.0 + 2.0 * constants.A * medium.kappa * decay * along.dot(surface.normal[t]));
  }
  return result;
}

void write_fields(const std::filesystem::path& folder, const TriangleMesh& mesh,
                  const Eigen::VectorXd& q, const Eigen::VectorXd& fluence) {
  std::filesystem::create_directories(folder);
  std::vector<double> vertices, triangles;
  for (const Eigen::Vector3d& v : mesh.vertices)
    vertices.insert(vertices.end(), v.begin(), v.end());
  for (const auto& t : mesh.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  const auto count = static_cast<std::size_t>(q.size());
  io::write_npy(folder / "vertices.npy", {mesh.vertices.size(), 3}, vertices);
  io::write_npy(folder / "triangles.npy", {mesh.triangles.size(), 3}, triangles);
  io::write_npy(folder / "q.npy", {count}, std::span<const double>(q.data(), count));
  io::write_npy(folder / "fluence.npy", {count}, std::span<const double>(fluence.data(), count));
}

Json measured(const Case& one, const Request& request) {
  const BoundaryConstants constants = boundary_constants(eta);
  const TriangleMesh mesh = make_shape(one.shape, size_mm, one.tessellation);
  const Surface surface = surface_of(mesh);
  const Prescribed exact = prescribed(surface, constants);
  std::vector<ObjectLight> lights(1);
  const double q_of_irradiance = diffuse_transmittance(constants) * constants.q_per_entering();
  for (const double q : exact.q) lights[0].diffuse.push_back(q / q_of_irradiance);
  const ObjectMedium everywhere(medium);
  const NoRays rays;
  const ObjectProblem problem{mesh, surface, rays, everywhere, eta, lights};
  const std::vector<Panel> panels = panels_of(mesh);
  const auto area = Eigen::Map<const Eigen::ArrayXd>(surface.area.data(),
                                                     static_cast<Eigen::Index>(surface.size()));
  const auto norm = [&](const Eigen::VectorXd& v) {
    return std::sqrt((area * v.array().square()).sum());
  };
  const double start = processor_seconds();
  const BoundaryAnswer answer = solve_boundary(problem, constants, panels, accuracy);
  const double cpu = processor_seconds() - start;
  const Eigen::VectorXd& fluence = answer.fluence[0];
  const BoundaryAnswer check = solve_boundary(problem, constants, panels, closer);
  if (request.has("fields")) {
    write_fields(request.folder / (one.shape + "-" + std::to_string(panels.size())), mesh, exact.q,
                 fluence);
  }
  return {{"shape", one.shape},
          {"triangles", panels.size()},
          {"error", norm(fluence - exact.fluence) / norm(exact.fluence)},
          {"sum_error", norm(fluence - check.fluence[0]) / norm(exact.fluence)},
          {"iterations", answer.iterations},
          {"setup_s", answer.setup_seconds},
          {"solve_s", answer.seconds},
          {"cpu_s", cpu},
          {"kB_per_triangle",
           static_cast<double>(answer.bytes) / 1e3 / static_cast<double>(panels.size())}};
}

void measure(const Request& request, Progress& progress, const Save& save) {
  std::vector<Case> cases;
  for (const std::string& shape : {std::string("sphere"), std::string("cube")}) {
    // 12 n² triangles; the sphere's cells are π/4 of its tessellation.
    const bool sphere = shape == "sphere";
    cases.push_back({shape, sphere ? 12 : 10});
    cases.push_back({shape, sphere ? 25 : 20});
    if (request.size == Size::quick) continue;
    cases.push_back({shape, sphere ? 51 : 40});
    cases.push_back({shape, sphere ? 117 : 92});
  }
  Json rows = Json::array();
  for (const Case& one : cases) {
    progress.update("bench boundary",
                    static_cast<double>(rows.size()) / static_cast<double>(cases.size()),
                    one.shape);
    rows.push_back(measured(one, request));
    save({{"kappa_mm", medium.kappa},
          {"mu_per_mm", medium.mu},
          {"A", boundary_constants(eta).A},
          {"size_mm", size_mm},
          {"accuracy", accuracy},
          {"rows", rows}});
  }
}

}  // namespace

Subject boundary_subject() {
  return {"boundary",
          "Error, cost and memory of boundary integrals against triangles "
          "(docs/boundary-integral.md)",
          R"(  kappamu-studies boundary -o out/

One resolution, one light, an exact solution prescribed. error: of the fluence at the
centroids, relative 2-norm; sum_error: of it, what fast sums and linear solver add,
found by solving again ten times as accurately (its time is not counted).)",
          {{"boundary", "spheres and cubes of 1,200 to 101,568 triangles", measure}},
          {{"fields",
            "Also write meshes, lights and solutions for studies/references/bempp_boundary.py",
            Setting::Kind::flag}}};
}

}  // namespace kappamu::studies
