#include "render/scene/object_shape.h"

#include <numbers>

#include "core/error.h"
#include "core/mesh/mesh_refine.h"
#include "core/mesh/shapes.h"
#include "io/mesh_file.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

constexpr std::size_t most_refined_triangles = 4'000'000;

/// In whatever unit and frame a file has; a box of three edges in theirs, its triangles alike on
/// all faces.
TriangleMesh unsized_shape(const SceneObject& object, std::vector<std::string>& warnings) {
  const auto* file = std::get_if<std::filesystem::path>(&object.shape);
  if (!file) {
    const int facets = object.facets_per_size.value_or(object.edges_per_size);
    const auto* edges = std::get_if<Vector3d>(&object.size_mm);
    if (edges && std::get<std::string>(object.shape) == "cube") return box_mesh(*edges, facets);
    return make_shape(std::get<std::string>(object.shape), 1.0, facets, object.proportion);
  }
  CheckedMesh checked = io::read_body(*file, object.morph);
  warnings.insert(warnings.end(), checked.mended.begin(), checked.mended.end());
  warnings.insert(warnings.end(), checked.warnings.begin(), checked.warnings.end());
  return std::move(checked.mesh);
}

}  // namespace

Eigen::Matrix3d turn_matrix(const Vector3d& degrees) {
  const Vector3d angle = degrees * std::numbers::pi / 180.0;
  return (Eigen::AngleAxisd(angle.z(), Vector3d::UnitZ()) *
          Eigen::AngleAxisd(angle.y(), Vector3d::UnitY()) *
          Eigen::AngleAxisd(angle.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

TriangleMesh make_object_mesh(const SceneObject& object, std::vector<std::string>& warnings) {
  try {
    TriangleMesh mesh = unsized_shape(object, warnings);
    const auto* file = std::get_if<std::filesystem::path>(&object.shape);
    const auto as = object.fitted_as       ? *object.fitted_as
                    : object.morph.empty() ? std::filesystem::path()
                                           : *file;
    const Eigen::AlignedBox3d box = bounding_box(as.empty() ? mesh : io::read_mesh(as).mesh);
    const auto* edge = std::get_if<double>(&object.size_mm);
    const Vector3d scale =
        edge ? Vector3d::Constant(*edge / box.sizes().maxCoeff())
             : Vector3d(std::get<Vector3d>(object.size_mm).cwiseQuotient(box.sizes()));
    for (Vector3d& vertex : mesh.vertices) vertex = scale.cwiseProduct(vertex - box.center());
    const double size = scale.cwiseProduct(box.sizes()).maxCoeff();
    return refined(mesh, 1.5 * size / object.edges_per_size, most_refined_triangles);
  } catch (const InputError& error) {
    throw InputError("object '" + object.name + "': " + error.what());
  }
}

}  // namespace kappamu::render
