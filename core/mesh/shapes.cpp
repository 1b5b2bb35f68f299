#include "core/mesh/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <unordered_map>
#include <utility>

#include "core/error.h"

namespace kappamu {

namespace {

using Eigen::Vector3d;

constexpr double pi = std::numbers::pi;
constexpr int most_tessellation = 400;

constexpr std::array<NamedShape, 10> shapes{
    {{"sphere", "", 0.0},
     {"cube", "", 0.0},
     {"slab", "thickness over edge", 0.25},
     {"sheet", "thickness over edge", 0.01},
     {"cylinder", "diameter over height", 0.5},
     {"torus", "diameter of the tube over that of the whole", 0.25},
     {"spike", "diameter of the base over height", 0.1},
     {"candle", "diameter over height", 0.4},
     {"box-with-void", "edge of the cubic void over that of the cube", 0.5},
     {"split-cube", "width of the gap over edge", 0.1}}};

/// Whether the diagonal between the first and third of four corners runs below the second and
/// fourth: on a body that bulges everywhere the other diagonal keeps the mesh convex.
bool is_hollow(const TriangleMesh& mesh, const std::array<int, 4>& corners) {
  const auto edge = [&](std::size_t k) -> Vector3d {
    return mesh.vertices[static_cast<std::size_t>(corners[k])] -
           mesh.vertices[static_cast<std::size_t>(corners[0])];
  };
  const Vector3d normal = edge(1).cross(edge(2));
  constexpr double flat = 1e-9;  // rounding of corners that lie in a plane
  return normal.dot(edge(3)) > flat * normal.norm() * edge(3).norm();
}

/// The surface of a box of `cells` cubes as squares of its lattice, each two triangles; `place`
/// puts lattice points, given as fractions of the box in [-1, 1], where they belong.
template <class Place>
TriangleMesh lattice_mesh(const std::array<int, 3>& cells, const Place& place) {
  TriangleMesh mesh;
  std::unordered_map<std::int64_t, int> known;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const std::int64_t key =
        (std::int64_t{at[2]} * (cells[1] + 1) + at[1]) * (cells[0] + 1) + at[0];
    const auto [entry, fresh] = known.try_emplace(key, static_cast<int>(mesh.vertices.size()));
    if (fresh) {
      Vector3d fraction;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        fraction[static_cast<int>(axis)] = 2.0 * at[axis] / cells[axis] - 1.0;
      }
      mesh.vertices.push_back(place(fraction));
    }
    return entry->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const bool far : {false, true}) {
      for (int i = 0; i < cells[u]; ++i) {
        for (int j = 0; j < cells[v]; ++j) {
          std::array<int, 4> corners{};
          for (std::size_t k = 0; k < 4; ++k) {
            std::array<int, 3> at{};
            at[axis] = far ? cells[axis] : 0;
            at[u] = i + (k == 1 || k == 2 ? 1 : 0);
            at[v] = j + (k >= 2 ? 1 : 0);
            corners[k] = vertex(at);
          }
          if (!far) std::swap(corners[1], corners[3]);
          if (is_hollow(mesh, corners))
            std::rotate(corners.begin(), corners.begin() + 1, corners.end());
          mesh.triangles.push_back({corners[0], corners[1], corners[2]});
          mesh.triangles.push_back({corners[0], corners[2], corners[3]});
        }
      }
    }
  }
  return mesh;
}

/// Edges along a length that is `share` of the longest extent.
int cells_along(double share, int tessellation, int fewest = 1) {
  return std::max(fewest, static_cast<int>(std::lround(tessellation * share)));
}

}  // namespace

TriangleMesh box_mesh(const Vector3d& size, int tessellation) {
  std::array<int, 3> cells{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cells[axis] = cells_along(size[static_cast<int>(axis)] / size.maxCoeff(), tessellation);
  }
  return lattice_mesh(cells,
                      [&](const Vector3d& f) -> Vector3d { return 0.5 * size.cwiseProduct(f); });
}

TriangleMesh sphere_mesh(double radius, int tessellation) {
  // A cube's lattice, spread so that its lines lie at equal angles.
  const int cells = cells_along(pi / 4.0, tessellation);
  return lattice_mesh({cells, cells, cells}, [&](const Vector3d& f) -> Vector3d {
    return radius * (f * (pi / 4.0)).array().tan().matrix().normalized();
  });
}

TriangleMesh cylinder_mesh(double radius, double height, int tessellation) {
  // Squares become circles (Shirley and Chiu 1997), each side a quarter of the way round.
  const double longest = std::max(2.0 * radius, height);
  const int aside_cells = cells_along(0.5 * pi * radius / longest, tessellation);
  const int along = cells_along(height / longest, tessellation);
  return lattice_mesh({aside_cells, aside_cells, along}, [&](const Vector3d& f) -> Vector3d {
    const bool x_side = std::abs(f.x()) >= std::abs(f.y());
    const double reach = x_side ? f.x() : f.y(), other = x_side ? f.y() : f.x();
    const double turn = reach == 0.0 ? 0.0 : pi / 4.0 * other / reach;
    const double toward = radius * reach * std::cos(turn), aside = radius * reach * std::sin(turn);
    return {x_side ? toward : aside, x_side ? aside : toward, 0.5 * height * f.z()};
  });
}

TriangleMesh torus_mesh(double major, double minor, int tessellation) {
  const int around = cells_along(pi, tessellation, 3);
  const int across = cells_along(pi * minor / (major + minor), tessellation, 3);
  TriangleMesh mesh;
  for (int i = 0; i < around; ++i) {
    const double turn = 2.0 * pi * i / around;
    for (int j = 0; j < across; ++j) {
      const double roll = 2.0 * pi * j / across, reach = major + minor * std::cos(roll);
      mesh.vertices.emplace_back(reach * std::cos(turn), reach * std::sin(turn),
                                 minor * std::sin(roll));
      const int next = (i + 1) % around * across, after = (j + 1) % across;
      mesh.triangles.push_back({i * across + j, next + j, next + after});
      mesh.triangles.push_back({i * across + j, next + after, i * across + after});
    }
  }
  return mesh;
}

namespace {

/// Of a ring about the z axis: radius, height, and how much it is fluted.
struct Ring {
  double radius, z, flute;
};
constexpr int flutes = 4;

/// Rings joined in their order, from a point of the axis below to another; the outside lies to the
/// right of the way. `around` vertices a ring.
TriangleMesh revolved(double first_z, const std::vector<Ring>& rings, double last_z, int around) {
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0.0, 0.0, first_z);
  for (const Ring& ring : rings) {
    for (int j = 0; j < around; ++j) {
      const double turn = 2.0 * pi * j / around;
      const double reach = ring.radius * (1.0 + ring.flute * (std::cos(flutes * turn) - 1.0));
      mesh.vertices.emplace_back(reach * std::cos(turn), reach * std::sin(turn), ring.z);
    }
  }
  mesh.vertices.emplace_back(0.0, 0.0, last_z);
  const int tip = static_cast<int>(mesh.vertices.size()) - 1;
  for (int j = 0; j < around; ++j) {
    const int k = (j + 1) % around;
    mesh.triangles.push_back({0, 1 + k, 1 + j});
    for (int low = 1; low + around < tip; low += around) {
      mesh.triangles.push_back({low + j, low + k, low + around + k});
      mesh.triangles.push_back({low + j, low + around + k, low + around + j});
    }
    mesh.triangles.push_back({tip, tip - around + j, tip - around + k});
  }
  return mesh;
}

/// Adds rings from the last one to `to`, `count` of them, evenly.
void go_on(std::vector<Ring>& rings, const Ring& to, int count) {
  const Ring from = rings.back();
  for (int i = 1; i <= count; ++i) {
    const double share = static_cast<double>(i) / count;
    rings.push_back({from.radius + share * (to.radius - from.radius),
                     from.z + share * (to.z - from.z),
                     from.flute + share * (to.flute - from.flute)});
  }
}

}  // namespace

TriangleMesh cone_mesh(double radius, double height, int tessellation) {
  const double longest = std::max(2.0 * radius, height);
  const int around = cells_along(2.0 * pi * radius / longest, tessellation, 8);
  const int rings_up = cells_along(std::hypot(radius, height) / longest, tessellation);
  const int rings_in = cells_along(radius / longest, tessellation);
  std::vector<Ring> rings{{radius / rings_in, -0.5 * height, 0.0}};
  if (rings_in > 1) go_on(rings, {radius, -0.5 * height, 0.0}, rings_in - 1);
  if (rings_up > 1) {
    go_on(rings, {radius / rings_up, (0.5 - 1.0 / rings_up) * height, 0.0}, rings_up - 1);
  }
  return revolved(-0.5 * height, rings, 0.5 * height, around);
}

TriangleMesh candle_mesh(double radius, double height, int tessellation) {
  constexpr double flute = 0.1, bore_radius = 0.55, bore_depth = 0.75;
  const double longest = std::max(2.0 * radius, height), bottom = -0.5 * height;
  const double bore = bore_radius * radius, floor = (0.5 - bore_depth) * height;
  const int around = 2 * flutes * cells_along(pi * radius / (flutes * longest), tessellation, 2);
  const auto cells = [&](double length) { return cells_along(length / longest, tessellation); };
  const int across = cells(radius), in = cells(bore);
  std::vector<Ring> rings{{radius / across, bottom, flute}};
  if (across > 1) go_on(rings, {radius, bottom, flute}, across - 1);
  go_on(rings, {radius, 0.5 * height, flute}, cells(height));
  go_on(rings, {bore, 0.5 * height, 0.0}, cells(radius - bore));
  go_on(rings, {bore, floor, 0.0}, cells(bore_depth * height));
  if (in > 1) go_on(rings, {bore / in, floor, 0.0}, in - 1);
  return revolved(bottom, rings, floor, around);
}

TriangleMesh moved(TriangleMesh mesh, const Vector3d& by) {
  for (Vector3d& vertex : mesh.vertices) vertex += by;
  return mesh;
}

TriangleMesh turned_inside_out(TriangleMesh mesh) {
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

TriangleMesh joined(TriangleMesh one, const TriangleMesh& other) {
  const int first = static_cast<int>(one.vertices.size());
  one.vertices.insert(one.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) {
    one.triangles.push_back({first + a, first + b, first + c});
  }
  return one;
}

TriangleMesh fitted(TriangleMesh mesh, double size_mm) {
  if (!(size_mm > 0.0) || !std::isfinite(size_mm)) {
    throw InputError("size_mm is " + std::to_string(size_mm) +
                     "; it is the longest edge of the object's box, a positive number");
  }
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  const Vector3d centre = box.center();
  const double scale = size_mm / box.sizes().maxCoeff();
  for (Vector3d& vertex : mesh.vertices) vertex = scale * (vertex - centre);
  return mesh;
}

std::span<const NamedShape> named_shapes() {
  return shapes;
}

TriangleMesh make_shape(std::string_view name, double size_mm, int tessellation,
                        std::optional<double> proportion) {
  const auto* shape = std::find_if(shapes.begin(), shapes.end(),
                                   [&](const NamedShape& s) { return s.name == name; });
  if (shape == shapes.end()) {
    std::string known;
    for (const NamedShape& s : shapes) known += (known.empty() ? "" : ", ") + std::string(s.name);
    throw InputError("there is no shape '" + std::string(name) + "'; the shapes are " + known);
  }
  if (tessellation < 1 || tessellation > most_tessellation) {
    throw InputError("tessellation is " + std::to_string(tessellation) +
                     "; choose a number from 1 to " + std::to_string(most_tessellation));
  }
  const double p = proportion.value_or(shape->usual);
  if (proportion && (shape->proportion.empty() || !(p > 0.0 && p < 1.0))) {
    throw InputError("shape '" + std::string(name) + "': proportion is " + std::to_string(p) +
                     (shape->proportion.empty() ? "; this shape has none, leave it out"
                                                : "; it is the " + std::string(shape->proportion) +
                                                      ", a number between 0 and 1"));
  }
  const Vector3d unit = Vector3d::Ones();
  const auto make = [&]() -> TriangleMesh {
    if (name == "sphere") return sphere_mesh(0.5, tessellation);
    if (name == "cube") return box_mesh(unit, tessellation);
    if (name == "slab" || name == "sheet") return box_mesh({1.0, 1.0, p}, tessellation);
    if (name == "cylinder") return cylinder_mesh(0.5 * p, 1.0, tessellation);
    if (name == "torus") return torus_mesh(0.5 * (1.0 - p), 0.5 * p, tessellation);
    if (name == "candle") return candle_mesh(0.5 * p, 1.0, tessellation);
    if (name == "spike") return cone_mesh(0.5 * p, 1.0, tessellation);
    if (name == "box-with-void") {
      const int inner = std::max(1, static_cast<int>(std::lround(tessellation * p)));
      return joined(box_mesh(unit, tessellation), turned_inside_out(box_mesh(p * unit, inner)));
    }
    const Vector3d half(0.5 * (1.0 - p), 1.0, 1.0), aside(0.25 * (1.0 + p), 0.0, 0.0);
    const TriangleMesh part = box_mesh(half, tessellation);
    return joined(moved(part, -aside), moved(part, aside));
  };
  return fitted(make(), size_mm);
}

}  // namespace kappamu
