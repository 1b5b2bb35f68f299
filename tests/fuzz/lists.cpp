// Recipes of edits, polycubes, correspondences of a structured-light scan.
#include <iterator>

#include "calib/projector/correspondences.h"
#include "core/mesh/polycube.h"
#include "io/polycube_file.h"
#include "render/edit/edit.h"
#include "tests/fuzz/targets.h"

namespace kappamu::fuzz {

namespace fs = std::filesystem;

namespace {

/// The first byte chooses.
struct {
  const char* file;
  void (*read)(const fs::path& file);
  const char* good;
} const kinds[] = {
    {"recipe.json",
     [](const fs::path& file) {
       const render::Recipe recipe = render::read_recipe(file);
       // What is read can be written, and is read again.
       write(folder() / "again.json", bytes_of(render::recipe_json(recipe, folder())));
       render::read_recipe(folder() / "again.json");
     },
     R"({"format": "kappamu-edit", "version": 1, "edits": [
{"operation": "multiply", "kappa": 2, "where": {"kind": "all"}, "channels": ["R"]},
{"operation": "blend", "share": 0.5, "mu": 0.1, "where": {"kind": "texture", "image": "a.png", "face": "z+", "depth_mm": 2}},
{"operation": "set", "mu": 0.1, "where": {"kind": "depth", "from_mm": 1, "to_mm": 2, "faces": ["x-"]}},
{"operation": "copy", "offset_mm": [1, 0, 0], "where": {"kind": "box", "from_mm": [0, 0, 0], "to_mm": [1, 1, 1]}},
{"operation": "add", "mu": 0.1, "where": {"kind": "brush", "strokes": [{"points_mm": [[0, 0, 0]],
 "inward": [[0, 0, 1]]}], "radius_mm": 1, "depth_mm": 2, "hardness": 0.5, "stretch": [1, 1, 2]}}]})"},
    {"a.polycube.json",
     [](const fs::path& file) {
       io::write_polycube(io::read_polycube(file), folder() / "again.json");
       io::read_polycube(folder() / "again.json");
     },
     R"({"format": "kappamu-polycube", "version": 1, "origin_mm": [0, 0, 0], "edge_mm": 2,
"boxes": [{"from": [0, 0, 0], "to": [1, 0, 0]}], "corners": [{"at": [0, 0, 0], "mm": [-0.5, 0, 0]}]})"},
    {"seen.csv",
     [](const fs::path& file) {
       capture::Camera camera;
       camera.width = 5;
       camera.height = 4;
       capture::Projector projector;
       projector.width = 8;
       projector.height = 6;
       calib::read_correspondences(file, camera, projector);
     },
     "x,y,column,row\n0,0,1.5,2\n4,3,7,5.25\n"},
};

}  // namespace

void read_list(Bytes bytes) {
  if (bytes.empty()) return;
  const auto& kind = kinds[bytes.front() % std::size(kinds)];
  write(folder() / kind.file, bytes.subspan(1));
  kind.read(folder() / kind.file);
}

void seed_list(const fs::path& seeds) {
  for (std::size_t i = 0; i < std::size(kinds); ++i) {
    const std::string content = static_cast<char>(i) + std::string(kinds[i].good);
    write(seeds / kinds[i].file, bytes_of(content));
  }
}

}  // namespace kappamu::fuzz
