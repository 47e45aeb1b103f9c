#include "octavo/io/zarr/zarr_source.h"

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "octavo/io/source/described_source.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/zarr/ome_image.h"
#include "octavo/io/zarr/zarr_hierarchy.h"
#include "octavo/io/zarr/zarr_layers.h"
#include "octavo/io/zarr/zarr_layout.h"

namespace octavo {

namespace {

/// An array, where it stands, and the image that it is a level of, where there is one.
struct FoundArray {
  std::shared_ptr<const ZarrHierarchy> hierarchy;
  std::string folder;  ///< of the array in the hierarchy
  ZarrLayout layout;
  std::optional<OmeImage> image;
  std::size_t level = 0;
};

/// The text of an array, of version 3 or 2; a value that is not there where there is no array.
ZarrValue array_text(const ZarrHierarchy& hierarchy, const std::string& folder) {
  const ZarrValue text = hierarchy.text(key_in(folder, "zarr.json"));
  if (text.is_there()) return text.at("node_type").text() == "array" ? text : ZarrValue{};
  return hierarchy.text(key_in(folder, ".zarray"));
}

/// What stands beside the groups and arrays of others.
ZarrValue group_attributes(const ZarrHierarchy& hierarchy) {
  const ZarrValue text = hierarchy.text("zarr.json");
  return text.is_there() ? text.at("attributes") : hierarchy.text(".zattrs");
}

/// Says what a group without an image is.
[[noreturn]] void reject_group(const ZarrValue& attributes, const std::string& path) {
  const ZarrValue inner = attributes.at("ome");
  const ZarrValue& ome = inner.is_there() ? inner : attributes;
  if (ome.at("plate").is_there()) {
    reject(path, "is a plate of wells: name one field of one well, as " + escaped(path) +
                     "/A/1/0");
  }
  if (ome.at("well").is_there() || ome.at("bioformats2raw.layout").is_there()) {
    reject(path, "holds several images: name one of them, as " + escaped(path) + "/0");
  }
  reject(path, "is a group of zarr without an OME-Zarr image (multiscales) in it; name an image or "
               "an array");
}

FoundArray array_of_image(std::shared_ptr<const ZarrHierarchy> hierarchy, OmeImage image,
                          int level) {
  const auto count = static_cast<int>(image.datasets.size());
  if (level < 0 || level >= count) {
    throw Error(ErrorKind::invalid_argument,
                "level " + std::to_string(level) + " is not there: levels are 0 to " +
                    std::to_string(count - 1),
                hierarchy->path())
        .with_field("level");
  }
  FoundArray found{std::move(hierarchy), image.datasets[static_cast<std::size_t>(level)].path,
                   {}, {}, static_cast<std::size_t>(level)};
  const ZarrValue text = array_text(*found.hierarchy, found.folder);
  if (!text.is_there()) {
    reject(found.hierarchy->path(), "its dataset " + escaped(found.folder) +
                                        " is no array: there is neither zarr.json nor .zarray");
  }
  found.layout = read_zarr_layout(text);
  found.image = std::move(image);
  return found;
}

/// The image in the folder above that has the array at `path` for a level.
std::optional<FoundArray> array_in_image(const std::string& path) {
  const std::filesystem::path above = std::filesystem::path(path).parent_path();
  const std::string folder = above.empty() ? "." : above.string();
  if (!is_zarr_folder(folder)) return std::nullopt;
  std::shared_ptr<const ZarrHierarchy> hierarchy = open_zarr_hierarchy(folder);
  std::optional<OmeImage> image = read_ome_image(group_attributes(*hierarchy));
  if (!image) return std::nullopt;
  const auto level = std::ranges::find(image->datasets, base_name(path), &OmeDataset::path);
  if (level == image->datasets.end()) return std::nullopt;
  const auto number = static_cast<int>(level - image->datasets.begin());
  return array_of_image(std::move(hierarchy), *std::move(image), number);
}

FoundArray find_array(const std::string& path, int level) {
  std::shared_ptr<const ZarrHierarchy> hierarchy = open_zarr_hierarchy(path);
  if (const ZarrValue text = array_text(*hierarchy, ""); text.is_there()) {
    if (is_folder(path)) {
      if (auto found = array_in_image(path)) return *std::move(found);
    }
    return {std::move(hierarchy), "", read_zarr_layout(text), {}, 0};
  }
  const ZarrValue attributes = group_attributes(*hierarchy);
  std::optional<OmeImage> image = read_ome_image(attributes);
  if (!image) reject_group(attributes, path);
  return array_of_image(std::move(hierarchy), *std::move(image), level);
}

/// Its axes: those of the image, or z, y, x of a plain array.
std::vector<std::string> axis_names(const FoundArray& found, const std::string& path) {
  std::vector<std::string> names;
  if (found.image) {
    for (const OmeAxis& axis : found.image->axes) names.push_back(axis.name);
  } else if (found.layout.dimensions() == 3) {
    names = {"z", "y", "x"};
  }
  if (names.size() != found.layout.dimensions()) {
    reject(path, "its array has " + std::to_string(found.layout.dimensions()) + " axes" +
                     (found.image ? ", its image " + std::to_string(names.size())
                                  : ": of an array that is no image, 3 are read"));
  }
  return names;
}

/// Finds what each axis is.
ZarrPart read_part(const FoundArray& found, const std::string& path,
                   SourceComponents& components) {
  ZarrPart part;
  const std::vector<std::string> names = axis_names(found, path);
  part.at.assign(names.size(), 0);
  std::string all;
  int space = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i];
    all += (all.empty() ? "" : " ") + escaped(name);
    std::size_t* const place = name == "z"   ? &part.z
                               : name == "y" ? &part.y
                               : name == "x" ? &part.x
                                             : nullptr;
    if (place != nullptr) {
      *place = i;
      ++space;
    } else if (name == "c") {
      components.channels = found.layout.shape[i];
    } else if (name == "t") {
      components.times = found.layout.shape[i];
    } else if (found.layout.shape[i] > 1) {
      reject(path, "has " + std::to_string(found.layout.shape[i]) + " places along its axis " +
                       escaped(name) + ": beside x, y and z only channels (c) and times (t) are "
                                       "chosen from");
    }
  }
  if (space != 3) reject(path, "its axes are " + all + "; a volume has z, y and x");
  if (found.image && components.channels > 1 &&
      found.image->channel_names.size() == static_cast<std::size_t>(components.channels)) {
    components.channel_names = found.image->channel_names;
  }
  return part;
}

void choose(const FoundArray& found, const ComponentChoice& choice, ZarrPart& part) {
  if (!found.image) return;
  if (const auto channel = found.image->axis("c")) part.at[*channel] = choice.channel;
  if (const auto time = found.image->axis("t")) part.at[*time] = choice.time;
}

/// Channels may be chosen by labels, which somebody chose: they are no part of a file unless
/// identity is kept.
SourceOptions with_numbered_channel(SourceFacts& facts, const SourceOptions& options,
                                    const std::string& path) {
  for (const std::string& label : facts.components.channel_names) {
    facts.identity.note("label", label);
  }
  if (options.keep_identity || options.channel.empty()) return options;
  SourceOptions numbered = options;
  numbered.channel = std::to_string(choose_component(facts.components, options, path).channel);
  if (facts.components.times <= 1 || options.time) facts.components.channel_names.clear();
  return numbered;
}

class ZarrSource final : public DescribedSource {
 public:
  ZarrSource(SourceFacts facts, std::shared_ptr<ZarrLayers> layers)
      : DescribedSource(std::move(facts)), layers_(std::move(layers)) {
    if (narrowing()) {
      wide_.resize(static_cast<std::size_t>(layers_->size().x * layers_->size().y) *
                   bytes_per_value(narrowing()->from));
    }
  }

  void read_plane(std::span<std::byte> plane) override {
    require_plane(plane);
    const std::int64_t z = take_plane_index();
    if (!narrowing()) return layers_->read(z, plane);
    layers_->read(z, wide_);
    narrow(*narrowing(), wide_, plane, {files().paths.front(), description().size.x, z, 0});
  }

  std::uint64_t resident_bytes() const override { return layers_->layer_bytes() + wide_.size(); }

 private:
  std::shared_ptr<ZarrLayers> layers_;
  std::vector<std::byte> wide_;
};

void require_memory(const ZarrLayers& layers, const SourceOptions& options,
                    const std::string& path) {
  if (options.max_memory_bytes == 0 || layers.layer_bytes() <= options.max_memory_bytes) return;
  throw Error(ErrorKind::limit_exceeded,
              "a layer of its chunks has " + std::to_string(layers.layer_bytes()) +
                  " bytes, more than the memory limit of " +
                  std::to_string(options.max_memory_bytes),
              path)
      .with_field("max_memory_bytes");
}

/// The texts and the chunks of the array.
PlaneFiles files_of(const FoundArray& found, const std::string& path) {
  std::vector<std::string> paths;
  for (const std::string& key :
       {std::string("zarr.json"), std::string(".zattrs"), key_in(found.folder, ".zarray")}) {
    if (const auto file = found.hierarchy->open(key)) paths.push_back(file->path());
  }
  const std::vector<std::string> chunks = found.hierarchy->files(found.folder);
  paths.insert(paths.end(), chunks.begin(), chunks.end());
  if (paths.empty()) paths.push_back(path);
  PlaneFiles files = files_of_volume(paths);
  if (found.image && found.level == 0) {
    files.voxels_sha256 = found.image->own.at("voxels_sha256").text().value_or("");
  }
  return files;
}

}  // namespace

bool is_zarr_source(const std::string& path) {
  return has_ending(path, ".ozx") ? !is_folder(path) : is_zarr_folder(path);
}

std::unique_ptr<PlaneSource> open_zarr_source(const std::string& path,
                                              const SourceOptions& options, int level) {
  const FoundArray found = find_array(path, level);
  SourceFacts facts;
  facts.format = found.image ? "OME-Zarr" : "zarr";
  ZarrPart part = read_part(found, path, facts.components);
  take_stored_type(facts, found.layout.type);
  if (found.image) take_ome_facts(*found.image, found.level, facts);
  const std::vector<std::int64_t>& shape = found.layout.shape;
  facts.description.size = {shape[part.x], shape[part.y], shape[part.z]};
  facts.files = files_of(found, path);
  facts.file_count = static_cast<std::int64_t>(facts.files.paths.size());
  settle(facts, with_numbered_channel(facts, options, path), path);
  choose(found, facts.choice, part);
  const auto layers =
      std::make_shared<ZarrLayers>(found.hierarchy, found.folder, found.layout, part,
                                   options.threads);
  require_memory(*layers, options, path);
  settle_narrowing(facts, [&](std::int64_t z, std::span<std::byte> plane) {
    layers->read(z, plane);
  });
  return std::make_unique<ZarrSource>(std::move(facts), layers);
}

}  // namespace octavo
