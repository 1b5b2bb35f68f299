#include "core/mesh/mesh_check.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/mesh/crossings.h"
#include "core/mesh/edges.h"
#include "core/mesh/texture.h"
#include "core/mesh/weld.h"
#include "core/shown_text.h"

namespace kappamu {

namespace {

using Eigen::Vector3d;

/// Of the box's longest edge: what counts as one place, and (squared) as no area.
constexpr double one_place = 1e-6;

class MeshCheck {
 public:
  MeshCheck(const TriangleMesh& mesh, const std::string& name, const TriangleName& triangle_name)
      : given_(mesh), name_(name), triangle_name_(triangle_name) {
    read();
    const std::size_t repeated = weld(equal_vertices(result_.mesh));
    welded_ += weld(ends_of_needles(result_.mesh, one_place * length_));
    drop_useless();
    welded_ += weld(gaps_of_edges(result_.mesh, one_place * length_));
    drop_useless();
    report_dropped();
    refuse_open_edges();
    orient_alike();
    turn_edges_of_caps();
    orient_outwards();
    find_self_intersections();
    drop_unused_vertices(repeated + welded_);
  }
  CheckedMesh take() { return std::move(result_); }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(name_ + ": " + what); }

  const Vector3d& vertex(int v) const { return result_.mesh.vertices[static_cast<std::size_t>(v)]; }
  Triangle& triangle(std::size_t t) { return result_.mesh.triangles[t]; }
  double area(const Triangle& t) const {
    return (vertex(t[1]) - vertex(t[0])).cross(vertex(t[2]) - vertex(t[0])).norm() / 2.0;
  }
  bool no_area(const Triangle& t) const {
    return area(t) < one_place * one_place * length_ * length_;
  }

  /// To 1e-4 of the box, wherever it lies.
  std::string place(const Vector3d& point) const {
    const int digits = std::clamp(3 - static_cast<int>(std::floor(std::log10(length_))), 0, 12);
    return formatted("(%.*f, %.*f, %.*f)", digits, point.x(), digits, point.y(), digits, point.z());
  }
  /// What the file calls triangle number t of those that are left.
  std::string named(std::size_t t) const { return triangle_name_(result_.source[t]); }
  /// "at (1, 2, 3) mm (triangle 7)", in the middle of an edge of a triangle.
  std::string place(const Edge& edge) const {
    return "at " + place(0.5 * (vertex(edge.low) + vertex(edge.high))) + " (" +
           named(static_cast<std::size_t>(edge.triangle)) + ")";
  }
  static std::string count(std::size_t n, const std::string& one, const std::string& many) {
    return std::to_string(n) + " " + (n == 1 ? one : many);
  }
  void mended(std::size_t n, const std::string& one, const std::string& many,
              const std::string& how) {
    if (n > 0) result_.mended.push_back(name_ + ": " + count(n, one, many) + " " + how);
  }

  void read() {
    if (given_.triangles.empty()) fail("has no triangles; give a closed triangle mesh");
    if (given_.triangles.size() > most_triangles) {
      fail("has " + std::to_string(given_.triangles.size()) + " triangles; at most " +
           std::to_string(most_triangles) + " are taken, decimate the mesh");
    }
    for (std::size_t v = 0; v < given_.vertices.size(); ++v) {
      if (given_.vertices[v].allFinite()) continue;
      fail("the position of vertex " + std::to_string(v) + " (from 0) is not finite; correct it");
    }
    for (std::size_t t = 0; t < given_.triangles.size(); ++t) {
      for (const int v : given_.triangles[t]) {
        if (v >= 0 && static_cast<std::size_t>(v) < given_.vertices.size()) continue;
        fail("triangle " + std::to_string(t) + " has vertex " + std::to_string(v) +
             ", but there are " + std::to_string(given_.vertices.size()) +
             " vertices, from 0; correct the mesh");
      }
    }
    Eigen::AlignedBox3d box;
    for (const Triangle& t : given_.triangles) {
      for (const int v : t) box.extend(given_.vertices[static_cast<std::size_t>(v)]);
    }
    length_ = box.sizes().maxCoeff();
    if (!(box.volume() > 0.0) || !std::isfinite(box.volume())) {
      fail(formatted("its box measures %.4g x %.4g x %.4g", box.sizes().x(), box.sizes().y(),
                     box.sizes().z()) +
           "; give a mesh that encloses a volume");
    }
    result_.mesh = given_;
    result_.source.resize(given_.triangles.size());
    std::iota(result_.source.begin(), result_.source.end(), 0);
  }

  /// Returns how many vertices of triangles are no more.
  std::size_t weld(const std::vector<int>& into) {
    std::vector<bool> used(result_.mesh.vertices.size());
    std::size_t welded = 0;
    for (Triangle& t : result_.mesh.triangles) {
      for (int& v : t) {
        const auto before = static_cast<std::size_t>(v);
        v = into[before];
        if (static_cast<std::size_t>(v) != before && !used[before]) ++welded;
        used[before] = true;
      }
    }
    return welded;
  }

  /// Fewer than three vertices, or the same three once more.
  void drop_useless() {
    auto& triangles = result_.mesh.triangles;
    std::vector<std::size_t> order(triangles.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::vector<Triangle> sorted = triangles;
    for (Triangle& t : sorted) std::sort(t.begin(), t.end());
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return sorted[a] < sorted[b]; });
    std::vector<bool> drop(triangles.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      const Triangle& t = sorted[order[i]];
      if (t[0] == t[1] || t[1] == t[2]) {
        drop[order[i]] = true;
        ++degenerate_;
      } else if (i > 0 && t == sorted[order[i - 1]]) {
        drop[order[i]] = true;
        ++repeated_;
      }
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      if (drop[i]) continue;
      triangles[kept] = triangles[i];
      result_.source[kept++] = result_.source[i];
    }
    triangles.resize(kept);
    result_.source.resize(kept);
    if (kept == 0) {
      fail("has no triangle of any area: of " + std::to_string(given_.triangles.size()) + ", " +
           std::to_string(degenerate_) + " have two corners at one place and " +
           std::to_string(repeated_) + " are given twice; give a closed triangle mesh");
    }
  }

  void report_dropped() {
    mended(welded_, "vertex", "vertices", "within 1e-6 of the box welded");
    mended(degenerate_, "triangle", "triangles", "without area dropped");
    mended(repeated_, "triangle", "triangles", "given twice dropped");
  }

  void refuse_open_edges() const {
    const std::vector<Edge> edges = edges_of(result_.mesh.triangles);
    std::size_t open = 0;
    std::optional<Edge> first, odd;
    for_each_edge(edges, [&](std::size_t begin, std::size_t end) {
      const Edge& edge = edges[begin];
      if (end - begin == 1) {
        ++open;
        if (!first || edge.triangle < first->triangle) first = edge;
      } else if ((end - begin) % 2 == 1 && (!odd || edge.triangle < odd->triangle)) {
        odd = edge;
      }
    });
    if (first) {
      fail("is not closed: it has " + count(open, "open edge", "open edges") + ", the first " +
           place(*first) + "; close the hole there");
    }
    if (odd) {
      fail("an odd number of triangles, more than two, meet at an edge " + place(*odd) +
           "; take away those that bound no volume");
    }
  }

  /// Neighbours across an edge run along it in opposite directions; what follows from one triangle
  /// to the next makes a component.
  void orient_alike() {
    const Orientation found = oriented_alike(result_.mesh.triangles);
    if (found.one_sided) {
      fail("has one side only (as a Moebius strip): its triangles cannot be oriented alike " +
           place(*found.one_sided) + "; separate it there");
    }
    result_.component = found.component;
    result_.components = found.components;
    if (found.components > most_components) {
      fail("consists of " + std::to_string(found.components) + " separate surfaces; at most " +
           std::to_string(most_components) + " are taken, remove the small ones");
    }
    // The smaller part of each component is what was wrong.
    const auto pieces = static_cast<std::size_t>(found.components);
    std::vector<std::size_t> size(pieces), turned(pieces);
    for (std::size_t t = 0; t < found.turned.size(); ++t) {
      const auto c = static_cast<std::size_t>(found.component[t]);
      ++size[c];
      turned[c] += found.turned[t] ? 1 : 0;
      if (found.turned[t]) std::swap(triangle(t)[1], triangle(t)[2]);
    }
    std::size_t wrong = 0;
    for (std::size_t c = 0; c < pieces; ++c) wrong += std::min(turned[c], size[c] - turned[c]);
    mended(wrong, "triangle", "triangles", "turned to face as its neighbours do");
    if (const std::optional<Edge> bad =
            unbalanced_edge(result_.mesh.triangles, result_.component)) {
      fail("more than two triangles meet at an edge " + place(*bad) +
           " and bound no volume between them; separate the surfaces there");
    }
  }

  /// A triangle whose three vertices lie on a line: the longest edge, which it shares with a
  /// neighbour, is replaced by the other diagonal of the two.
  void turn_edges_of_caps() {
    std::size_t turned = 0;
    for (int pass = 0; pass < 8; ++pass) {
      std::vector<bool> flat;
      for (const Triangle& t : result_.mesh.triangles) flat.push_back(no_area(t));
      if (std::find(flat.begin(), flat.end(), true) == flat.end()) break;
      turned += turn_caps(result_.mesh, flat);
    }
    mended(turned, "triangle", "triangles", "on a line given area by turning an edge");
    for (std::size_t t = 0; t < result_.mesh.triangles.size(); ++t) {
      const Triangle& flat = result_.mesh.triangles[t];
      if (!no_area(flat)) continue;
      fail(named(t) + " at " + place(vertex(flat[0])) +
           " has no area, and turning edges does not help; take it away and close the gap");
    }
  }

  /// Whether the middle of triangle t lies within an odd number of the other components. Three rays
  /// vote, should one meet an edge.
  bool within_others(const MeshCrossings& crossings, std::size_t t) const {
    const Triangle& corners = result_.mesh.triangles[t];
    const Vector3d from = (vertex(corners[0]) + vertex(corners[1]) + vertex(corners[2])) / 3.0;
    const int own = result_.component[t];
    int odd = 0;
    for (const Vector3d& direction :
         {Vector3d(0.61, 0.37, 0.70), Vector3d(-0.53, 0.79, -0.31), Vector3d(0.23, -0.89, 0.41)}) {
      odd += crossings
                 .along(from, direction,
                        [&](int other) {
                          return result_.component[static_cast<std::size_t>(other)] != own;
                        })
                 .number %
             2;
    }
    return odd >= 2;
  }

  void orient_outwards() {
    const auto pieces = static_cast<std::size_t>(result_.components);
    std::vector<double> volume(pieces);
    std::vector<int> sample(pieces, -1);
    for (std::size_t t = 0; t < result_.component.size(); ++t) {
      const auto c = static_cast<std::size_t>(result_.component[t]);
      const Triangle& corners = triangle(t);
      volume[c] += (vertex(corners[0]) - vertex(0))
                       .dot((vertex(corners[1]) - vertex(0)).cross(vertex(corners[2]) - vertex(0)));
      if (sample[c] < 0) sample[c] = static_cast<int>(t);
    }
    const MeshCrossings crossings(result_.mesh);
    std::vector<std::size_t> bodies, voids;  // of those turned
    std::vector<bool> turn(pieces);
    for (std::size_t c = 0; c < pieces; ++c) {
      const bool within = within_others(crossings, static_cast<std::size_t>(sample[c]));
      turn[c] = within ? volume[c] > 0.0 : volume[c] < 0.0;
      if (turn[c]) (within ? voids : bodies).push_back(c);
    }
    for (std::size_t t = 0; t < result_.component.size(); ++t) {
      if (turn[static_cast<std::size_t>(result_.component[t])]) {
        std::swap(triangle(t)[1], triangle(t)[2]);
      }
    }
    const auto first = [&](const std::vector<std::size_t>& of) {
      if (of.empty() || pieces == 1) return std::string();
      return ": " + std::string(of.size() == 1 ? "that of " : "the first that of ") +
             named(static_cast<std::size_t>(sample[of.front()]));
    };
    mended(bodies.size(), "body", "bodies", "that faced inwards turned inside out" + first(bodies));
    mended(voids.size(), "surface", "surfaces",
           "inside another made a void by turning it inside out" + first(voids));
  }

  /// Bodies whose edges meet edges and corners of others exactly do not pierce any of their
  /// triangles; some of theirs lie inside another body and some outside.
  void refuse_bodies_partly_inside(const MeshCrossings& crossings) const {
    constexpr std::size_t most_looks = 256;  // of a component
    const auto pieces = static_cast<std::size_t>(result_.components);
    if (pieces == 1) return;
    std::vector<std::vector<std::size_t>> triangles(pieces);
    for (std::size_t t = 0; t < result_.component.size(); ++t) {
      triangles[static_cast<std::size_t>(result_.component[t])].push_back(t);
    }
    for (const std::vector<std::size_t>& own : triangles) {
      const bool within = within_others(crossings, own.front());
      const std::size_t looks = std::min(own.size(), most_looks);
      for (std::size_t i = 1; i < looks; ++i) {
        const std::size_t t = own[i * own.size() / looks];
        if (within_others(crossings, t) == within) continue;
        fail("one of its bodies is partly inside another: of " + named(own.front()) + " and " +
             named(t) + " one is, the other is not; unite the bodies or move them apart");
      }
    }
  }

  void find_self_intersections() {
    const MeshCrossings crossings(result_.mesh);
    const MeshCrossings::Pairs pairs = crossings.crossing_pairs(result_.component);
    if (!pairs.all) {
      fail("too many of its triangles lie across each other to find its inside; remesh it");
    }
    if (!pairs.between) refuse_bodies_partly_inside(crossings);
    if (!pairs.first) return;
    const auto where_of = [this](const std::pair<int, int>& pair) {
      const auto one = static_cast<std::size_t>(pair.first);
      const Triangle& t = triangle(one);
      return named(one) + " and " + named(static_cast<std::size_t>(pair.second)) + " at " +
             place((vertex(t[0]) + vertex(t[1]) + vertex(t[2])) / 3.0);
    };
    // Neither a void of the other nor a body beside it.
    if (pairs.between) {
      fail("two of its bodies intersect or lie upon each other, the first time by " +
           where_of(*pairs.between) + "; unite them or move them apart");
    }
    const std::string where = where_of(*pairs.first);
    const double hidden = crossings.hidden_share();
    if (hidden > most_hidden_surface) {
      fail("intersects itself, the first time by " + where + ", which puts " + percent(hidden) +
           " of its surface inside or outside the body; unite the parts that overlap");
    }
    result_.warnings.push_back(
        name_ + ": " + count(pairs.count, "pair of triangles crosses", "pairs of triangles cross") +
        " each other, the first being " + where + "; less than " + percent(most_hidden_surface) +
        " of the surface is wrong by it");
  }
  static std::string percent(double share) { return shown_number(100.0 * share, "%.3g %%"); }

  /// `welded`: vertices that have become others.
  void drop_unused_vertices(std::size_t welded) {
    std::vector<int> number(result_.mesh.vertices.size());
    for (const Triangle& t : result_.mesh.triangles) {
      for (const int v : t) number[static_cast<std::size_t>(v)] = 1;
    }
    std::vector<Vector3d> kept;
    for (std::size_t v = 0; v < number.size(); ++v) {
      const bool used = number[v] == 1;
      number[v] = static_cast<int>(kept.size());
      if (used) kept.push_back(result_.mesh.vertices[v]);
    }
    for (Triangle& t : result_.mesh.triangles) {
      for (int& v : t) v = number[static_cast<std::size_t>(v)];
    }
    const std::size_t unused = given_.vertices.size() - kept.size() - welded;
    mended(unused, "vertex", "vertices", "of no triangle dropped");
    result_.mesh.vertices = std::move(kept);
  }

  const TriangleMesh& given_;
  const std::string& name_;
  const TriangleName& triangle_name_;
  double length_ = 0.0;
  std::size_t welded_ = 0, degenerate_ = 0, repeated_ = 0;
  CheckedMesh result_;
};

}  // namespace

std::string numbered_triangle(int triangle) {
  return "triangle " + std::to_string(triangle);
}

CheckedMesh check_mesh(const TriangleMesh& mesh, const std::string& name,
                       const TriangleName& triangle_name) {
  CheckedMesh checked = MeshCheck(mesh, name, triangle_name).take();
  checked.mesh.texture = texture_from(mesh, checked.mesh, checked.source);
  return checked;
}

}  // namespace kappamu
