#include "app/viewer/panel/slice_window.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>

#include "report/drawing/picture.h"

namespace kappamu::app {

namespace {

constexpr float longest_edge_px = 260.0F;  ///< at scale 1
constexpr int colours = 32;                ///< of the scale

std::array<std::uint8_t, 3> colour_of(double share) {
  return report::colour_of(report::ColourMap::viridis, share);
}

/// What a slice's colours stand for.
struct ValueRange {
  double least = 0.0, most = 0.0;
  explicit ValueRange(const Volume<double>& volume) {
    const auto [low, high] = std::minmax_element(volume.values().begin(), volume.values().end());
    least = *low;
    most = *high;
  }
  double share(double value) const { return (value - least) / std::max(most - least, 1e-300); }
};

/// How a slice lies in its picture: columns from the left along one axis, rows from the top along
/// another, each forwards or backwards.
class Layout {
 public:
  Layout(const GridShape& shape, const Slice& slice, const Eigen::Matrix3d& axes,
         const render::Camera& camera)
      : slice_(slice) {
    const Eigen::Vector3d right =
        (camera.target_mm - camera.position_mm).cross(camera.up).normalized();
    column_axis_ = slice.axis == 0 ? 1 : 0;
    row_axis_ = slice.axis == 2 ? 1 : 2;
    columns = shape.extent(column_axis_);
    rows = shape.extent(row_axis_);
    leftwards_ = axes.col(column_axis_).dot(right) < -least_slope;
    downwards_ = axes.col(row_axis_).dot(camera.up) < -least_slope;
  }

  std::array<int, 3> voxel(int column, int row) const {
    std::array<int, 3> voxel{};
    voxel[static_cast<std::size_t>(slice_.axis)] = slice_.index;
    voxel[static_cast<std::size_t>(column_axis_)] = leftwards_ ? columns - 1 - column : column;
    voxel[static_cast<std::size_t>(row_axis_)] = downwards_ ? row : rows - 1 - row;
    return voxel;
  }

  int columns = 0, rows = 0;

 private:
  /// An axis along the line of sight is neither left nor right.
  static constexpr double least_slope = 1e-3;

  const Slice& slice_;
  int column_axis_ = 0, row_axis_ = 0;
  bool leftwards_ = false, downwards_ = false;
};

std::vector<std::uint8_t> coloured(const Volume<double>& volume, const ValueRange& range,
                                   const Layout& layout) {
  std::vector<std::uint8_t> pixels;
  for (int row = 0; row < layout.rows; ++row) {
    for (int column = 0; column < layout.columns; ++column) {
      const auto [x, y, z] = layout.voxel(column, row);
      const auto colour = colour_of(range.share(volume(x, y, z)));
      pixels.insert(pixels.end(), colour.begin(), colour.end());
    }
  }
  return pixels;
}

/// Voxels of the whole volume by their value, from its least to its largest.
std::array<float, 48> histogram(const Volume<double>& volume, const ValueRange& range) {
  std::array<float, 48> counts{};
  for (const double value : volume.values()) {
    const auto bin = static_cast<std::size_t>(counts.size() * range.share(value));
    counts[std::min(bin, counts.size() - 1)] += 1.0F;
  }
  return counts;
}

/// The colours with the values at their ends and in their middle, and a mark at `value`.
void draw_colours(const ValueRange& range, const std::string& unit, double value, float width,
                  float scale) {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float height = 12.0F * scale;
  const auto at = [&](double share) { return corner.x + width * static_cast<float>(share); };
  for (int i = 0; i < colours; ++i) {
    const auto [r, g, b] = colour_of((i + 0.5) / colours);
    list.AddRectFilled({at(static_cast<double>(i) / colours), corner.y},
                       {at((i + 1.0) / colours), corner.y + height}, IM_COL32(r, g, b, 255));
  }
  const float mark = at(std::clamp(range.share(value), 0.0, 1.0));
  list.AddLine({mark, corner.y - 2.0F * scale}, {mark, corner.y + height + 2.0F * scale},
               IM_COL32(255, 255, 255, 255), 2.0F * scale);
  ImGui::Dummy({width, height});
  const float left = ImGui::GetCursorPosX();
  const auto write = [&](double number, const std::string& after, float share) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.3g", number);
    const std::string words = text + after;
    ImGui::SetCursorPosX(left + share * (width - ImGui::CalcTextSize(words.c_str()).x));
    ImGui::TextUnformatted(words.c_str());
  };
  write(range.least, "", 0.0F);
  ImGui::SameLine();
  write(0.5 * (range.least + range.most), "", 0.5F);
  ImGui::SameLine();
  write(range.most, " " + unit, 1.0F);
}

}  // namespace

void SliceWindow::draw(const io::VolumeSet& set, const Eigen::Matrix3d& axes,
                       const render::Camera& camera, float scale, Slice& slice) {
  const std::vector<io::NamedVolume> volumes = io::named_volumes(set);
  const GridShape& shape = set.shape();
  slice.volume = std::min(slice.volume, volumes.size() - 1);
  slice.index = std::clamp(slice.index, 0, shape.extent(slice.axis) - 1);
  const io::NamedVolume& shown = volumes[slice.volume];

  ImGui::SetNextWindowPos({ImGui::GetIO().DisplaySize.x - 8.0F * scale, 8.0F * scale},
                          ImGuiCond_Once, {1.0F, 0.0F});
  ImGui::Begin("slice", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::PushItemWidth(160.0F * scale);
  if (ImGui::BeginCombo("volume", shown.name.c_str())) {
    for (std::size_t i = 0; i < volumes.size(); ++i) {
      if (ImGui::Selectable(volumes[i].name.c_str(), i == slice.volume)) slice.volume = i;
    }
    ImGui::EndCombo();
  }
  ImGui::Combo("across", &slice.axis, "x\0y\0z\0");
  slice.index = std::clamp(slice.index, 0, shape.extent(slice.axis) - 1);
  ImGui::SliderInt("voxel", &slice.index, 0, shape.extent(slice.axis) - 1);
  ImGui::PopItemWidth();

  const Layout layout(shape, slice, axes, camera);
  const int columns = layout.columns, rows = layout.rows;
  const ValueRange range(*shown.volume);
  const std::vector<std::uint8_t> pixels = coloured(*shown.volume, range, layout);
  const float edge = longest_edge_px * scale;
  const float voxel = edge / static_cast<float>(std::max(columns, rows));
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 size{voxel * static_cast<float>(columns), voxel * static_cast<float>(rows)};
  picture_.draw(pixels, columns, rows, size.x, size.y);
  int column = columns / 2, row = rows / 2;
  if (ImGui::IsMouseHoveringRect(corner, {corner.x + size.x, corner.y + size.y})) {
    const ImVec2 mouse = ImGui::GetMousePos();
    column = std::clamp(static_cast<int>((mouse.x - corner.x) / voxel), 0, columns - 1);
    row = std::clamp(static_cast<int>((mouse.y - corner.y) / voxel), 0, rows - 1);
  }
  const auto [x, y, z] = layout.voxel(column, row);
  const std::array<float, 48> counts = histogram(*shown.volume, range);
  ImGui::PlotHistogram("##voxels", counts.data(), static_cast<int>(counts.size()), 0,
                       "voxels by value", 0.0F, *std::max_element(counts.begin(), counts.end()),
                       {edge, 48.0F * scale});
  draw_colours(range, shown.unit, (*shown.volume)(x, y, z), edge, scale);
  const double h = shape.voxel_mm;
  ImGui::Text("at %.2f, %.2f, %.2f mm", h * (x + 0.5), h * (y + 0.5), h * (z + 0.5));
  for (std::size_t c = 0; c < set.channels.size(); ++c) {
    const bool deviations = !set.kappa_std.empty() && !set.mu_std.empty();
    ImGui::Text("%-4s kappa %.4g", set.channels[c].c_str(), set.media[c].kappa(x, y, z));
    ImGui::SameLine();
    if (deviations) ImGui::Text("+- %.2g", set.kappa_std[c](x, y, z));
    if (deviations) ImGui::SameLine();
    ImGui::Text("mm, mu %.4g", set.media[c].mu(x, y, z));
    ImGui::SameLine();
    if (deviations) ImGui::Text("+- %.2g", set.mu_std[c](x, y, z));
    if (deviations) ImGui::SameLine();
    ImGui::TextUnformatted("1/mm");
  }
  ImGui::End();
}

}  // namespace kappamu::app
