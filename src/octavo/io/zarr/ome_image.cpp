#include "octavo/io/zarr/ome_image.h"

#include <algorithm>
#include <array>

#include "octavo/core/metadata.h"
#include "octavo/core/place_known.h"
#include "octavo/io/source/length_unit.h"

namespace octavo {

namespace {

constexpr std::size_t kMostAxes = 5;
constexpr std::size_t kMostDatasets = 64;
constexpr std::array<const char*, 3> kSpace = {"x", "y", "z"};

std::vector<OmeAxis> read_axes(const ZarrValue& image) {
  const ZarrValue list = image.at("axes");
  // Before version 0.3 images had five axes and did not say so.
  if (!list.is_there()) return {{"t", ""}, {"c", ""}, {"z", ""}, {"y", ""}, {"x", ""}};
  const std::vector<ZarrValue> items = list.items();
  if (items.empty() || items.size() > kMostAxes) list.reject("an image has 2 to 5 axes");
  std::vector<OmeAxis> axes;
  for (const ZarrValue& one : items) {
    const auto bare = one.text();
    const std::string name = bare ? *bare : one.at("name").text().value_or("");
    if (name.empty()) list.reject("an axis has no name");
    axes.push_back({name, one.at("unit").text().value_or("")});
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (axes[i].name == axes[j].name) list.reject("two axes are " + escaped(axes[i].name));
    }
  }
  return axes;
}

/// Applies the scales and translations of a list to those of a level.
void take_transforms(const ZarrValue& list, std::size_t axes, OmeDataset& dataset) {
  for (const ZarrValue& one : list.items()) {
    const std::string type = one.at("type").text().value_or("");
    if (type == "identity") continue;
    const auto numbers = one.at(type).numbers();
    const bool is_scale = type == "scale";
    if (!is_scale && type != "translation") {
      one.reject("a transformation \"" + escaped(type) + "\" is not read");
    }
    if (!numbers || numbers->size() != axes) {
      one.reject(type + " has no number for each of " + std::to_string(axes) + " axes");
    }
    dataset.has_scale |= is_scale;
    for (std::size_t i = 0; i < axes; ++i) {
      if (is_scale) dataset.scale[i] *= (*numbers)[i];
      dataset.translation[i] = is_scale ? dataset.translation[i] * (*numbers)[i]
                                        : dataset.translation[i] + (*numbers)[i];
    }
  }
}

std::vector<OmeDataset> read_datasets(const ZarrValue& image, std::size_t axes) {
  std::vector<OmeDataset> datasets;
  const std::vector<ZarrValue> items = image.at("datasets").items();
  if (items.empty() || items.size() > kMostDatasets) {
    image.reject("an image has 1 to 64 datasets, " + std::to_string(items.size()) + " found");
  }
  for (const ZarrValue& one : items) {
    OmeDataset dataset{one.at("path").text().value_or(""), std::vector<double>(axes, 1),
                       std::vector<double>(axes, 0)};
    if (!is_zarr_key(dataset.path)) {
      one.reject("a dataset has the path \"" + escaped(dataset.path) +
                 "\", which does not lie in the image");
    }
    take_transforms(one.at("coordinateTransformations"), axes, dataset);
    take_transforms(image.at("coordinateTransformations"), axes, dataset);
    datasets.push_back(std::move(dataset));
  }
  return datasets;
}

/// Names and colors, each label once.
LabelNames read_labels(const ZarrValue& image_label) {
  LabelNames labels;
  const auto label_of = [](const ZarrValue& one) { return one.at("label-value").whole(); };
  for (const ZarrValue& one : image_label.at("properties").items()) {
    const auto label = label_of(one);
    const auto name = one.at("name").text();
    if (label && name) labels.set(*label, {*name, {}});
  }
  for (const ZarrValue& one : image_label.at("colors").items()) {
    const auto label = label_of(one);
    const auto rgba = one.at("rgba").wholes();
    const bool is_color = label && rgba && rgba->size() >= 3 &&
                          std::ranges::all_of(*rgba, [](auto v) { return v >= 0 && v <= 255; });
    if (!is_color || *label == 0) continue;
    LabelColor color{};
    for (std::size_t i = 0; i < 3; ++i) color[i] = static_cast<std::uint8_t>((*rgba)[i]);
    labels.set(*label, {labels.name_of(*label), color});
  }
  return labels;
}

template <std::size_t N>
std::optional<std::array<double, N>> numbers_of(const ZarrValue& value) {
  const auto numbers = value.numbers();
  if (!numbers || numbers->size() != N) return std::nullopt;
  std::array<double, N> result{};
  std::ranges::copy(*numbers, result.begin());
  return result;
}

/// What an export of this program says beside.
void take_own_facts(const OmeImage& image, std::size_t level, const Point3& place,
                    SourceFacts& facts) {
  VolumeDescription& description = facts.description;
  const auto direction = numbers_of<9>(image.own.at("direction"));
  const auto spacing = numbers_of<3>(image.own.at("spacing_mm"));
  const auto origin = numbers_of<3>(image.own.at("origin_mm"));
  if (!direction || !spacing || !origin) return;
  Geometry& geometry = description.geometry;
  geometry.direction = *direction;
  // The place of a level is one along the axes of the grid, in mm.
  geometry.origin_mm =
      level == 0 ? *origin : Geometry{{}, {1, 1, 1}, *direction}.to_world(place);
  if (level == 0) geometry.spacing_mm = *spacing;
  description.rescale.slope = image.own.at("slope").number().value_or(1);
  description.rescale.intercept = image.own.at("intercept").number().value_or(0);
  const std::string content = image.own.at("content").text().value_or("");
  if (content == "label map") description.kind = VolumeKind::labels;
  const Metadata metadata = Metadata::read(image.own.at("metadata").json());
  const MetadataFacts& own = metadata.facts();
  facts.noted.labels = own.labels;
  facts.noted.made_by = own.made_by;
  facts.noted.lossy_source = own.lossy_source;
  // What a coarse level says for itself: its voxels lie half a voxel from where they lay.
  facts.place_known = own.place_known;
  if (level > 0) {
    VolumeDescription finest;
    finest.geometry = {*spacing, *origin, *direction};
    finest.metadata = metadata;
    facts.place_known = is_place_known(finest);
  }
  facts.noted.unit = own.unit;
  double lost = metadata.source_max_error();
  if (own.coding) lost += own.coding->max_error.value_or(0);
  if (lost > 0) facts.noted.source_max_error = lost;
  facts.spacing_known = metadata.is_spacing_known();
}

}  // namespace

std::optional<std::size_t> OmeImage::axis(std::string_view wanted) const {
  const auto found = std::ranges::find(axes, wanted, &OmeAxis::name);
  if (found == axes.end()) return std::nullopt;
  return static_cast<std::size_t>(found - axes.begin());
}

std::optional<OmeImage> read_ome_image(const ZarrValue& attributes) {
  const ZarrValue inner = attributes.at("ome");
  const ZarrValue& ome = inner.is_there() ? inner : attributes;
  const std::vector<ZarrValue> images = ome.at("multiscales").items();
  if (images.empty()) return std::nullopt;
  const ZarrValue& first = images.front();
  OmeImage image;
  image.name = first.at("name").text().value_or("");
  image.axes = read_axes(first);
  image.datasets = read_datasets(first, image.axes.size());
  for (const ZarrValue& channel : ome.at("omero").at("channels").items()) {
    image.channel_names.push_back(channel.at("label").text().value_or(""));
  }
  const ZarrValue labels = ome.at("image-label");
  image.is_labels = labels.is_there();
  if (image.is_labels) image.labels = read_labels(labels);
  image.own = attributes.at("octavo");
  return image;
}

void take_ome_facts(const OmeImage& image, std::size_t level, SourceFacts& facts) {
  const OmeDataset& dataset = image.datasets[level];
  Point3 place{};
  bool has_units = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t at = *image.axis(kSpace[axis]);
    const std::optional<double> mm = unit_in_mm(image.axes[at].unit);
    has_units &= mm.has_value();
    facts.description.geometry.spacing_mm[axis] = dataset.scale[at] * mm.value_or(1);
    place[axis] = dataset.translation[at] * mm.value_or(1);
  }
  facts.spacing_known = has_units && dataset.has_scale;
  facts.description.geometry.origin_mm = facts.spacing_known ? place : Point3{};
  if (!facts.spacing_known && dataset.has_scale && !image.own.is_there()) {
    facts.warnings.emplace_back("its axes have no unit of length that is known here: its scale and "
                                "place are left out", "spacing_mm");
  }
  if (image.is_labels) facts.description.kind = VolumeKind::labels;
  facts.noted.labels = image.labels;
  // A stage of a microscope is no place in a body.
  if (facts.spacing_known) facts.place_known = false;
  if (!image.own.is_there()) facts.identity.note("name", image.name);
  take_own_facts(image, level, place, facts);
}

}  // namespace octavo
