#include "render/scene/composed_field.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/process_memory.h"
#include "core/rigid.h"
#include "io/volume/volume_file.h"
#include "render/material/baked_field.h"
#include "render/material/pattern.h"
#include "render/material/shell_field.h"
#include "render/material/surface_places.h"
#include "render/scene/object_media.h"
#include "render/scene/object_shape.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

class SolidField : public MaterialField {
 public:
  explicit SolidField(const ObjectMedia& media) : media_(media) {}
  ColourCoefficients at(const Place& place) const override {
    ColourCoefficients result;
    for (std::size_t c = 0; c < result.size(); ++c) result[c] = media_.channels[c]->at(place.point);
    return result;
  }
  double detail_mm() const override {
    return media_.channels[0]->voxel_mm().value_or(MaterialField::detail_mm());
  }
  bool of_point_alone(double /*shallow*/, double /*deep*/) const override { return true; }

 private:
  ObjectMedia media_;
};

using Fields = std::vector<std::unique_ptr<MaterialField>>;

double finest(const Fields& fields, double own) {
  for (const auto& field : fields) own = std::min(own, field->detail_mm());
  return own;
}

class MixedField : public MaterialField {
 public:
  MixedField(Fields fields, const Pattern& pattern)
      : fields_(std::move(fields)), pattern_(pattern) {}
  ColourCoefficients at(const Place& place) const override {
    const double share = pattern_at(pattern_, place.point);
    ColourCoefficients result = fields_[0]->at(place);
    const ColourCoefficients other = fields_[1]->at(place);
    for (std::size_t c = 0; c < result.size(); ++c) {
      // σt' = 1/(3κ) and μ are proportional to concentrations, κ is not.
      const double extinction = (1.0 - share) / result[c].kappa + share / other[c].kappa;
      result[c] = {1.0 / extinction, (1.0 - share) * result[c].mu + share * other[c].mu};
    }
    return result;
  }
  double detail_mm() const override {
    const bool veins = pattern_.kind == Pattern::Kind::veins;
    return finest(fields_, pattern_.size_mm * (veins ? std::min(0.5 * pattern_.width, 0.1) : 0.1));
  }
  bool of_point_alone(double shallow, double deep) const override {
    return std::all_of(fields_.begin(), fields_.end(),
                       [&](const auto& field) { return field->of_point_alone(shallow, deep); });
  }

 private:
  Fields fields_;
  Pattern pattern_;
};

class LayeredField : public MaterialField {
 public:
  LayeredField(Fields fields, std::vector<double> thickness)
      : fields_(std::move(fields)), thickness_(std::move(thickness)) {}
  ColourCoefficients at(const Place& place) const override {
    return fields_[layer_at(place.depth)]->at(place);
  }
  double detail_mm() const override {
    return finest(fields_, 0.5 * *std::min_element(thickness_.begin(), thickness_.end()));
  }
  bool of_point_alone(double shallow, double deep) const override {
    const std::size_t layer = layer_at(shallow);
    return layer == layer_at(deep) && fields_[layer]->of_point_alone(shallow, deep);
  }

 private:
  std::size_t layer_at(double depth) const {
    double bottom = 0.0;
    for (std::size_t k = 0; k < thickness_.size(); ++k) {
      bottom += thickness_[k];
      if (depth < bottom) return k;
    }
    return thickness_.size();
  }

  Fields fields_;
  std::vector<double> thickness_;
};

/// A body inside the object.
class Inclusion {
 public:
  explicit Inclusion(const SceneObject& part)
      : mesh_(made(part)),
        places_(mesh_),
        box_(bounding_box(mesh_)),
        object_from_part_{turn_matrix(part.turn_deg), part.position_mm},
        part_from_object_(object_from_part_.inverse()),
        field_(make_field(part.material, mesh_).field) {}
  Inclusion(const Inclusion&) = delete;
  Inclusion& operator=(const Inclusion&) = delete;

  std::optional<ColourCoefficients> at(const Vector3d& point) const {
    const Vector3d here = part_from_object_ * point;
    if (!box_.contains(here)) return std::nullopt;
    double outside = 0.0;
    const Place place = places_.at(here, 0, outside);
    if (outside > 0.0) return std::nullopt;
    return field_->at(place);
  }
  /// In the object's frame.
  Eigen::AlignedBox3d box_in_object() const {
    Eigen::AlignedBox3d box;
    for (const Vector3d& vertex : mesh_.vertices) box.extend(object_from_part_ * vertex);
    return box;
  }
  double detail_mm() const {
    constexpr double share = 1.0 / 16.0;
    return std::min(field_->detail_mm(), share * box_.sizes().minCoeff());
  }

 private:
  static TriangleMesh made(const SceneObject& part) {
    std::vector<std::string> warnings;
    return make_object_mesh(part, warnings);
  }
  TriangleMesh mesh_;
  SurfacePlaces places_;
  Eigen::AlignedBox3d box_;
  Rigid object_from_part_, part_from_object_;
  std::unique_ptr<MaterialField> field_;
};

class PartedField : public MaterialField {
 public:
  /// Throws InputError where a part lies beside the object.
  PartedField(std::unique_ptr<MaterialField> around, const std::vector<SceneObject>& parts,
              const Eigen::AlignedBox3d& object)
      : around_(std::move(around)) {
    for (const SceneObject& part : parts) {
      parts_.push_back(std::make_unique<Inclusion>(part));
      if (parts_.back()->box_in_object().intersects(object)) continue;
      throw InputError("parts[" + std::to_string(parts_.size() - 1) +
                       "] lies outside the object; change its position_mm");
    }
  }
  ColourCoefficients at(const Place& place) const override {
    for (auto part = parts_.rbegin(); part != parts_.rend(); ++part) {
      if (const auto inside = (*part)->at(place.point)) return *inside;
    }
    return around_->at(place);
  }
  double detail_mm() const override {
    double detail = around_->detail_mm();
    for (const auto& part : parts_) detail = std::min(detail, part->detail_mm());
    return detail;
  }
  bool of_point_alone(double shallow, double deep) const override {
    return around_->of_point_alone(shallow, deep);
  }

 private:
  std::unique_ptr<MaterialField> around_;
  std::vector<std::unique_ptr<Inclusion>> parts_;
};

NamedField composed(const ComposedMaterial& material, const TriangleMesh& mesh) {
  NamedField result;
  Fields fields;
  for (const Material& part : material.materials) {
    NamedField made = make_field(part, mesh);
    if (fields.empty()) result.eta = made.eta;
    result.source += (fields.empty() ? "" : " with ") + made.source;
    fields.push_back(std::move(made.field));
  }
  if (const auto* pattern = std::get_if<Pattern>(&material.by)) {
    result.field = std::make_unique<MixedField>(std::move(fields), *pattern);
  } else if (const auto* layers = std::get_if<ComposedMaterial::Layers>(&material.by)) {
    result.field = std::make_unique<LayeredField>(std::move(fields), layers->thickness_mm);
  } else {
    result.field = std::make_unique<PartedField>(
        std::move(fields.front()), std::get<ComposedMaterial::Parts>(material.by).parts,
        bounding_box(mesh));
  }
  return result;
}

/// Scores of the largest block that the material wraps [bytes]; nothing where it wraps none.
std::optional<double> scores_bytes(const Material& material) {
  std::optional<double> most;
  if (const auto* parts = std::get_if<std::shared_ptr<const ComposedMaterial>>(&material)) {
    for (const Material& part : (*parts)->materials) {
      if (const auto bytes = scores_bytes(part)) most = std::max(most.value_or(0.0), *bytes);
    }
  }
  const auto* volume = std::get_if<VolumeMaterial>(&material);
  if (volume == nullptr || volume->placement != VolumeMaterial::Placement::shell) return most;
  return NormalScores::bytes(io::read_volume(io::find_volume(volume->volume)));
}

}  // namespace

NamedField make_field(const Material& material, const TriangleMesh& mesh) {
  if (const auto* parts = std::get_if<std::shared_ptr<const ComposedMaterial>>(&material))
    return composed(**parts, mesh);
  const auto* volume = std::get_if<VolumeMaterial>(&material);
  if (volume == nullptr || volume->placement != VolumeMaterial::Placement::shell) {
    SceneObject object;
    object.name = "part";
    object.material = material;
    std::vector<std::string> warnings;
    const ObjectMedia media = make_object_media(object, mesh, mesh, warnings);
    return {std::make_unique<SolidField>(media), media.eta, media.source};
  }
  const std::filesystem::path file = io::find_volume(volume->volume);
  const io::VolumeSet set = colour_channels(io::read_volume(file), file.string());
  return {std::make_unique<ShellField>(set, volume->shell, mesh), set.eta, file.string()};
}

void expect_wrap_memory(const Scene& scene, Progress& progress) {
  for (const SceneObject& object : scene.objects) {
    const std::optional<double> scores = scores_bytes(object.material);
    if (!scores) continue;
    // The object's voxels are copied once, into the media.
    const double bytes = *scores + 2.0 * bytes_per_baked_voxel * most_baked_voxels;
    if (bytes > usable_memory()) {
      throw InputError("object '" + object.name + "': wrapping its block needs " +
                       gigabytes(bytes) + " of memory where this machine has " +
                       gigabytes(main_memory()) + "; fit with larger voxels");
    }
    progress.update("wrap " + object.name, 0.0, "up to " + gigabytes(bytes) + " of memory");
  }
}

}  // namespace kappamu::render
