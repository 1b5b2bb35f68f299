// Polycubes read as they were written, as a person writes them, and damaged ones refused by name.
#include "io/polycube_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/error.h"
#include "tests/own_folder.h"

namespace kappamu::io {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using Eigen::Vector3i;

Polycube read_text(const std::string& fields) {
  const OwnFolder folder;
  const fs::path file = folder / "polycube.json";
  std::ofstream(file) << R"({"format": "kappamu-polycube", "version": 1, )" << fields << "}";
  return read_polycube(file);
}

std::string refused(const std::string& fields) {
  try {
    read_text(fields);
  } catch (const InputError& error) {
    return error.what();
  }
  return "not refused";
}

/// An L of three cells.
Polycube drawn() {
  return lattice_polycube({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, Vector3d(-3.0, 0.5, 2.0), 1.7);
}

TEST(PolycubeFile, IsReadAsWritten) {
  Polycube polycube = drawn();
  polycube.mapped[3] += Vector3d(0.1, 0.02, -0.3);
  polycube.mapped[7] = Vector3d(1.0 / 3.0, 1e-17, -2.0);
  const OwnFolder folder;
  write_polycube(polycube, folder / "polycube.json");
  const Polycube again = read_polycube(folder / "polycube.json");
  EXPECT_EQ(again.cells, polycube.cells);
  EXPECT_EQ(again.corners, polycube.corners);
  for (std::size_t i = 0; i < again.mapped.size(); ++i) {
    EXPECT_LE((again.mapped[i] - polycube.mapped[i]).norm(), 1e-9 * 1.7) << i;
  }
}

TEST(PolycubeFile, IsShortWhereAPersonDrawsOnlyBoxes) {
  const Polycube read = read_text(
      R"("_comment": "a table", "origin_mm": [0, 0, 10], "edge_mm": 5,
         "boxes": [{"from": [0, 0, 1], "to": [2, 2, 1]}, {"from": [1, 1, 0], "to": [1, 1, 1]}],
         "corners": [{"at": [0, 0, 2], "mm": [-1, -1, 21]}])");
  EXPECT_EQ(read.cells.size(), 10U) << "cells in two boxes count once";
  const auto corner = std::find(read.corners.begin(), read.corners.end(), Vector3i(0, 0, 2));
  ASSERT_NE(corner, read.corners.end());
  EXPECT_EQ(read.mapped[static_cast<std::size_t>(corner - read.corners.begin())],
            Vector3d(-1, -1, 21));
  EXPECT_EQ(read.mapped[0], Vector3d(5, 5, 10)) << "corner (1, 1, 0), where it is not moved";
}

TEST(PolycubeFile, WhatIsWrongIsNamed) {
  const std::string lattice = R"("origin_mm": [0, 0, 0], "edge_mm": 1, )";
  const std::string cell = R"("boxes": [{"from": [0, 0, 0], "to": [0, 0, 0]}])";
  const auto expect = [](const std::string& sentence, const std::string& part) {
    EXPECT_NE(sentence.find("polycube.json"), std::string::npos) << sentence;
    EXPECT_NE(sentence.find(part), std::string::npos) << sentence;
  };
  expect(refused(cell), "origin_mm");
  expect(refused(lattice + R"("boxes": [])"), "boxes");
  expect(refused(lattice + cell + R"(, "cubes": 1)"), "cubes");
  expect(refused(R"("origin_mm": [0, 0, 0], "edge_mm": 0, )" + cell), "edge_mm");
  expect(refused(lattice + R"("boxes": [{"from": [0, 0, 0], "to": [0, 0, -1]}])"),
         "boxes[0].to lies below 'from'");
  expect(refused(lattice + R"("boxes": [{"from": [0, 0, 0], "to": [999, 999, 999]}])"),
         "boxes[0] brings more than 2000000 cells");
  expect(refused(lattice + R"("boxes": [{"from": [0, 0, 0], "to": [0, 0, 1e9]}])"),
         "boxes[0].to[2]");
  expect(refused(lattice + R"("boxes": [{"from": [0, 0, 0], "to": [0, 0, 0]},
                                        {"from": [1, 1, 0], "to": [1, 1, 0]}])"),
         "make a polycube that is in several pieces");
  expect(refused(lattice + cell + R"(, "corners": [{"at": [2, 0, 0], "mm": [0, 0, 0]}])"),
         "corners[0].at is a corner of no cell");
  expect(refused(lattice + cell + R"(, "corners": [{"at": [1, 0, 0], "mm": [0, 0, 0]},
                                                   {"at": [1, 0, 0], "mm": [0, 0, 1]}])"),
         "corners[1].at is given twice");
  expect(refused(lattice + cell + R"(, "corners": [{"at": [1, 0, 0], "mm": [0, 0]}])"),
         "corners[0].mm");
}

}  // namespace
}  // namespace kappamu::io
