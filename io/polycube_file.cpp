#include "io/polycube_file.h"

#include <map>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/json_node.h"

namespace kappamu::io {

using Eigen::Vector3d;
using Eigen::Vector3i;
using nlohmann::json;

namespace {

constexpr const char* polycube_format = "kappamu-polycube";
constexpr int farthest_place = 100'000;
constexpr double farthest_mm = 1e6, smallest_edge_mm = 1e-6;

Vector3i place_from(const JsonNode& node) {
  Vector3i place;
  const auto items = node.exactly(3);
  for (int axis = 0; axis < 3; ++axis) {
    const JsonNode& item = items[static_cast<std::size_t>(axis)];
    place[axis] = item.integer();
    if (std::abs(place[axis]) > farthest_place) {
      item.fail("must lie between -100000 and 100000");
    }
  }
  return place;
}

Vector3d point_from(const JsonNode& node) {
  Vector3d point;
  const auto items = node.exactly(3);
  for (int axis = 0; axis < 3; ++axis) {
    point[axis] = items[static_cast<std::size_t>(axis)].number_between(-farthest_mm, farthest_mm);
  }
  return point;
}

json place_to(const Vector3i& place) {
  return {place.x(), place.y(), place.z()};
}

void add_box(const JsonNode& box, std::vector<Vector3i>& cells) {
  box.expect_fields({"from", "to"});
  const Vector3i from = place_from(box["from"]), to = place_from(box["to"]);
  if ((to.array() < from.array()).any()) box["to"].fail("lies below 'from'; both are included");
  const double count = (to - from + Vector3i::Ones()).cast<double>().prod();
  if (static_cast<double>(cells.size()) + count > static_cast<double>(most_polycube_cells)) {
    box.fail("brings more than " + std::to_string(most_polycube_cells) + " cells");
  }
  for (int z = from.z(); z <= to.z(); ++z) {
    for (int y = from.y(); y <= to.y(); ++y) {
      for (int x = from.x(); x <= to.x(); ++x) cells.emplace_back(x, y, z);
    }
  }
}

struct ByPlace {
  bool operator()(const Vector3i& a, const Vector3i& b) const {
    return std::make_tuple(a.z(), a.y(), a.x()) < std::make_tuple(b.z(), b.y(), b.x());
  }
};

}  // namespace

Polycube read_polycube(const std::filesystem::path& file) {
  const JsonDocument document(file, "docs/formats.md", JsonComments::allowed);
  const JsonNode root = document.root();
  root.expect_fields({"format", "version", "origin_mm", "edge_mm", "boxes"}, {"corners"});
  root["format"].choice({polycube_format});
  if (root["version"].integer() != 1) root["version"].fail("must be 1");
  const Vector3d origin = point_from(root["origin_mm"]);
  const double edge = root["edge_mm"].number_between(smallest_edge_mm, farthest_mm);
  std::vector<Vector3i> cells;
  for (const JsonNode& box : root["boxes"].items(1)) add_box(box, cells);
  Polycube made = lattice_polycube(std::move(cells), origin, edge);
  if (const auto problem = polycube_problem(made.cells)) {
    root["boxes"].fail("make a polycube that " + *problem);
  }
  made.file = file.string();
  if (!root.has("corners")) return made;
  std::map<Vector3i, std::size_t, ByPlace> number;
  for (std::size_t i = 0; i < made.corners.size(); ++i) number.emplace(made.corners[i], i);
  std::vector<bool> given(made.corners.size(), false);
  for (const JsonNode& corner : root["corners"].items(0)) {
    corner.expect_fields({"at", "mm"});
    const auto found = number.find(place_from(corner["at"]));
    if (found == number.end()) corner["at"].fail("is a corner of no cell");
    if (given[found->second]) corner["at"].fail("is given twice");
    given[found->second] = true;
    made.mapped[found->second] = point_from(corner["mm"]);
  }
  return made;
}

void write_polycube(const Polycube& polycube, const std::filesystem::path& file) {
  // The box of the mapped corners, of the lattice's shape in the mean, gives origin and edge.
  Vector3d low = polycube.mapped.at(0), high = low;
  Vector3i first = polycube.corners.at(0), last = first;
  for (std::size_t i = 0; i < polycube.corners.size(); ++i) {
    low = low.cwiseMin(polycube.mapped[i]);
    high = high.cwiseMax(polycube.mapped[i]);
    first = first.cwiseMin(polycube.corners[i]);
    last = last.cwiseMax(polycube.corners[i]);
  }
  const double edge = (high - low).sum() / (last - first).sum();
  const Vector3d origin = low - edge * first.cast<double>();
  json written{{"format", polycube_format},
               {"version", 1},
               {"origin_mm", {origin.x(), origin.y(), origin.z()}},
               {"edge_mm", edge},
               {"boxes", json::array()},
               {"corners", json::array()}};
  // Cells are sorted with x fastest: neighbours along x make a box.
  for (std::size_t i = 0; i < polycube.cells.size();) {
    std::size_t end = i + 1;
    while (end < polycube.cells.size() &&
           polycube.cells[end] == polycube.cells[end - 1] + Vector3i::UnitX()) {
      ++end;
    }
    written["boxes"].push_back(
        {{"from", place_to(polycube.cells[i])}, {"to", place_to(polycube.cells[end - 1])}});
    i = end;
  }
  constexpr double moved = 1e-9;
  for (std::size_t i = 0; i < polycube.corners.size(); ++i) {
    const Vector3d& mm = polycube.mapped[i];
    if ((mm - origin - edge * polycube.corners[i].cast<double>()).norm() <= moved * edge) continue;
    written["corners"].push_back(
        {{"at", place_to(polycube.corners[i])}, {"mm", {mm.x(), mm.y(), mm.z()}}});
  }
  if (written["corners"].empty()) written.erase("corners");
  write_text_atomically(file, written.dump(1) + "\n");
}

}  // namespace kappamu::io
