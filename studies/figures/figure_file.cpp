#include "studies/figures/figure_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "studies/record.h"

namespace kappamu::studies {

namespace {

constexpr int quick_width = 48;  ///< [px]
constexpr int quick_edges = 10;

[[noreturn]] void fail_figure(const std::filesystem::path& file, const std::string& what) {
  throw InputError(file.string() + ": " + what);
}

/// The field, or `standard`; throws where there is neither.
template <class T>
T field_of(const std::filesystem::path& file, const Json& node, const std::string& name,
           const T* standard = nullptr) {
  if (!node.is_object() || !node.contains(name)) {
    if (standard != nullptr) return *standard;
    fail_figure(file, "field '" + name + "' is missing; add it");
  }
  try {
    return node.at(name).get<T>();
  } catch (const Json::exception&) {
    fail_figure(file, "field '" + name + "' has another type than it must");
  }
}

SceneChanges changes_of(const std::filesystem::path& file, const Json& node) {
  SceneChanges changes;
  if (!node.contains("set")) return changes;
  for (const auto& [pointer, value] : node.at("set").items()) {
    if (pointer.empty() || pointer.front() != '/') {
      fail_figure(file, "'" + pointer + "' in 'set' is no place in a scene; write /objects/0/...");
    }
    changes.emplace_back(pointer, value.dump());
  }
  return changes;
}

FigureColumn column_of(const std::filesystem::path& file, const Json& node) {
  const std::string picture = "picture", none;
  const double range = 0.5;
  const bool shared = false;
  FigureColumn column;
  column.name = field_of<std::string>(file, node, "name");
  column.set = changes_of(file, node);
  column.own_exposure = field_of(file, node, "own_exposure", &shared);
  column.range = field_of(file, node, "range", &range);
  const auto shows = field_of(file, node, "shows", &picture);
  if (shows == "difference") {
    column.shows = FigureColumn::Shows::difference;
  } else if (shows == "error") {
    column.shows = FigureColumn::Shows::error;
  } else if (shows == "clusters") {
    column.shows = FigureColumn::Shows::clusters;
    const auto at = field_of<std::array<double, 2>>(file, node, "triangle_at");
    column.triangle_at = {at[0], at[1]};
  } else if (shows != "picture") {
    fail_figure(file, "'" + shows + "' is not shown; write picture, difference, error or clusters");
  }
  column.of = field_of(file, node, "of", &none);
  column.from = field_of(file, node, "from", &none);
  return column;
}

void expect_picture(const Figure& figure, const std::string& name) {
  const bool found = std::any_of(figure.columns.begin(), figure.columns.end(), [&](const auto& c) {
    return c.name == name && c.shows == FigureColumn::Shows::picture;
  });
  if (!found) fail_figure(figure.file, "'" + name + "' is no column with pictures");
}

void apply(const std::filesystem::path& file, const SceneChanges& changes, Json& scene) {
  for (const auto& [pointer, value] : changes) {
    try {
      scene[Json::json_pointer(pointer)] = Json::parse(value);
    } catch (const Json::exception&) {
      fail_figure(file, "the scene has no place " + pointer);
    }
  }
}

}  // namespace

Figure read_figure(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) fail_figure(file, "the figure cannot be read; give a folder that has it");
  const Json root = Json::parse(stream, nullptr, false, true);
  if (root.is_discarded()) fail_figure(file, "the figure is not valid JSON");
  Figure figure;
  figure.file = file;
  figure.name = file.stem().string();
  figure.source = field_of<std::string>(file, root, "figure");
  figure.title = field_of<std::string>(file, root, "title");
  figure.scene = field_of<Json>(file, root, "scene").dump();
  figure.edges_per_size = field_of(file, root, "edges_per_size", &figure.edges_per_size);
  for (const Json& row : field_of<Json>(file, root, "rows")) {
    figure.rows.push_back({field_of<std::string>(file, row, "name"), changes_of(file, row)});
  }
  for (const Json& column : field_of<Json>(file, root, "columns")) {
    figure.columns.push_back(column_of(file, column));
  }
  if (figure.rows.empty() || figure.columns.empty()) {
    fail_figure(file, "a figure needs at least one row and one column");
  }
  for (const FigureColumn& column : figure.columns) {
    if (column.shows == FigureColumn::Shows::picture ||
        column.shows == FigureColumn::Shows::clusters)
      continue;
    expect_picture(figure, column.of);
    expect_picture(figure, column.from);
  }
  return figure;
}

render::Scene scene_of_cell(const Figure& figure, const FigureRow& row, const FigureColumn& column,
                            bool quick) {
  Json scene = Json::parse(figure.scene);
  scene["format"] = "kappamu-scene";
  scene["version"] = 1;
  apply(figure.file, row.set, scene);
  apply(figure.file, column.set, scene);
  render::Scene read = render::read_scene(
      scene.dump(), figure.file, " (row '" + row.name + "', column '" + column.name + "')");
  for (render::SceneObject& object : read.objects) {
    object.edges_per_size = quick ? quick_edges : figure.edges_per_size;
  }
  if (quick) {
    const double share = static_cast<double>(quick_width) / read.film.width;
    read.film.width = quick_width;
    read.film.height = std::max(1, static_cast<int>(share * read.film.height));
    read.film.samples = 4;
    read.model.tolerance = 0.1;
    if (read.model.parameters.contains("photons")) read.model.parameters["photons"] = 2000.0;
  }
  return read;
}

}  // namespace kappamu::studies
