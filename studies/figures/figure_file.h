// A figure of a paper as a file: one scene, and what each row and column changes of it. Cells are
// scenes of `kappamu render`, arranged as the paper has its pictures.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "render/scene/scene.h"

namespace kappamu::studies {

/// Places in a scene (JSON pointers, such as /objects/0/material) and the values set there, as
/// JSON.
using SceneChanges = std::vector<std::pair<std::string, std::string>>;

struct FigureRow {
  std::string name;
  SceneChanges set;
};

struct FigureColumn {
  enum class Shows {
    picture,     ///< of the scene, at the exposure of its row's first
    difference,  ///< (of − from)/from of the pictures, blue −range to red +range
    error,       ///< |of − from|/from, logarithmic, blue 0.001 to red 1
    clusters     ///< of the scene, that give one triangle its light (cluster_tile.h)
  };
  std::string name;
  Shows shows = Shows::picture;
  SceneChanges set;                       ///< of a picture or of clusters
  std::string of, from;                   ///< columns of the other kinds
  double range = 0.5;                     ///< of a difference
  bool own_exposure = false;              ///< of a picture
  Eigen::Vector2d triangle_at{0.5, 0.5};  ///< of clusters, shares of the film's width and height
};

struct Figure {
  std::filesystem::path file;
  std::string name;         ///< the file's, without its end
  std::string source;       ///< such as "[T] table 5.1"
  std::string title;        ///< one sentence
  std::string scene;        ///< JSON
  int edges_per_size = 64;  ///< of every object: coarser meshes have less noise of random walks
  std::vector<FigureRow> rows;
  std::vector<FigureColumn> columns;
};

/// Throws InputError naming file and field.
Figure read_figure(const std::filesystem::path& file);

/// The scene of a cell. `quick`: a small film and a coarse answer. Throws as read_scene() does.
render::Scene scene_of_cell(const Figure& figure, const FigureRow& row, const FigureColumn& column,
                            bool quick);

}  // namespace kappamu::studies
