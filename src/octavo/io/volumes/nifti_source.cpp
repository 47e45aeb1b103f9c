#include "octavo/io/volumes/nifti_source.h"

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "octavo/core/checked.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/source/streamed_source.h"
#include "octavo/io/volumes/nifti_header.h"

namespace octavo {

namespace {

constexpr std::int64_t kIntentLabel = 1002;

constexpr std::int64_t kRgb = 128;
constexpr std::int64_t kRgba = 2304;

StoredType stored_type_of(const NiftiHeader& header, const std::string& path) {
  static const std::map<std::int64_t, StoredType> kTypes = {
      {kRgb, VoxelType::uint8}, {kRgba, VoxelType::uint8},
      {2, VoxelType::uint8},   {4, VoxelType::int16},    {8, VoxelType::int32},
      {16, VoxelType::float32}, {256, VoxelType::int8},  {512, VoxelType::uint16},
      {768, VoxelType::uint32}, {64, WideType::float64}, {1024, WideType::int64},
      {1280, WideType::uint64}};
  const auto found = kTypes.find(header.datatype);
  if (found == kTypes.end()) {
    reject(path, "voxels of " + nifti_type_name(header.datatype) +
                     " are not read; integers of 8 to 64 bits, float of 32 or 64 bits, RGB and "
                     "RGBA are. Convert it to one of these first");
  }
  return found->second;
}

/// Values of one voxel: a color has several.
std::int64_t values_of_type(std::int64_t datatype) {
  return datatype == kRgb ? 3 : datatype == kRgba ? 4 : 1;
}

/// Nothing depends on bitpix: the type says how long a voxel is.
void note_bits(const NiftiHeader& header, StoredType type, std::vector<Warning>& warnings) {
  const std::int64_t bits = 8 * static_cast<std::int64_t>(bytes_per_value(type)) *
                            values_of_type(header.datatype);
  if (header.voxel_bits == 0 || header.voxel_bits == bits) return;
  warnings.push_back("bitpix of the header says that a voxel has " +
                     std::to_string(header.voxel_bits) + " bits, datatype " +
                     std::to_string(header.datatype) + " has " + std::to_string(bits) +
                     ": the datatype counts");
}

Size3 read_size(const NiftiHeader& header, const std::string& path) {
  const std::int64_t count = header.dim[0];
  if (count < 1 || count > 7) reject(path, "it claims " + std::to_string(count) + " dimensions");
  Size3 size{1, 1, 1};
  for (std::int64_t axis = 0; axis < count; ++axis) {
    const std::int64_t length = header.dim[static_cast<std::size_t>(axis) + 1];
    if (length < 1) {
      reject(path, "the length of axis " + std::to_string(axis + 1) + " is " +
                       std::to_string(length));
    }
    if (axis < 3) {
      size[static_cast<int>(axis)] = length;
    } else if (length > 1 && axis > 4) {
      reject(path, "an axis " + std::to_string(axis + 1) + " of length " + std::to_string(length) +
                       " (behind space, time and channels) is not read; take out one part first");
    }
  }
  return size;
}

std::int64_t length_of(const NiftiHeader& header, std::size_t axis) {
  return static_cast<std::int64_t>(axis) <= header.dim[0] ? header.dim[axis] : 1;
}

/// Axis 4 is time, axis 5 counts the values of a voxel, as does a color.
SourceComponents components_of(const NiftiHeader& header, const std::string& path) {
  SourceComponents components;
  components.times = length_of(header, 4);
  components.channels = length_of(header, 5);
  const std::int64_t colors = values_of_type(header.datatype);
  if (colors == 1) return components;
  if (components.channels > 1) {
    reject(path, std::to_string(components.channels) + " channels of " +
                     nifti_type_name(header.datatype) + " are not read; take out one first");
  }
  components.channels = colors;
  components.channel_names = color_names(colors);
  return components;
}

/// Colors alternate; volumes of other channels and times stand behind one another.
void take_component(const NiftiHeader& header, const SourceFacts& facts, VoxelRun& run) {
  const std::uint64_t bytes = checked_mul(
      stored_plane_bytes(facts), static_cast<std::uint64_t>(facts.description.size.z), "volume");
  const SourceComponents& components = facts.components;
  const ComponentChoice& choice = facts.choice;
  if (header.datatype == kRgb || header.datatype == kRgba) {
    run.values_per_voxel = components.channels;
    run.value_index = choice.channel;
    run.take_volume(choice.time, components.times, bytes);
    return;
  }
  const std::int64_t volumes = checked_count(components.channels, components.times, "volumes");
  run.take_volume(choice.channel * components.times + choice.time, volumes, bytes);
}

/// Colors are not scaled (NIfTI-1, "Data scaling").
Rescale read_rescale(const NiftiHeader& header, const std::string& path) {
  if (values_of_type(header.datatype) > 1) return {};
  // A slope of 0 says that there is no scaling (NIfTI-1, "Data scaling").
  if (header.slope == 0 || !std::isfinite(header.slope)) return {};
  if (!std::isfinite(header.intercept)) {
    reject(path, "scl_inter of the header is no number, and its slope is one; repair the header");
  }
  return {header.slope, header.intercept};
}

/// The file with the voxels: the header's own, or the .img beside it.
std::string voxel_file(const std::string& path, bool is_pair) {
  if (!is_pair) return path;
  for (const char* ending : {".hdr", ".hdr.gz"}) {
    if (!has_ending(path, ending)) continue;
    const std::string name = base_name(path);
    const std::string stem = name.substr(0, name.size() - std::string(ending).size());
    return sibling_path(path, stem + (has_ending(path, ".gz") ? ".img.gz" : ".img"));
  }
  reject(path, "its header says that the voxels are in a separate .img, but it is not named .hdr");
}

/// minimum  the first byte at which voxels may start
std::uint64_t voxel_start(const NiftiHeader& header, const std::string& path,
                          std::int64_t minimum) {
  if (!header.voxel_offset) {
    reject(path, "vox_offset of the header is no number of bytes that a file has; repair the "
                 "header");
  }
  const std::int64_t start = *header.voxel_offset;
  if (start < minimum) {
    reject(path, "the voxels are said to start at byte " + std::to_string(start) +
                     (start < 0 ? ", before the file"
                                : ", inside the header of " + std::to_string(minimum) + " bytes") +
                     "; repair the header");
  }
  return static_cast<std::uint64_t>(start);
}

}  // namespace

std::unique_ptr<PlaneSource> open_nifti_source(const std::string& path,
                                               const SourceOptions& options) {
  const NiftiHeader header = read_nifti_header(path);
  SourceFacts facts;
  facts.format = "NIfTI-" + std::to_string(header.version);
  facts.file_count = header.is_pair ? 2 : 1;
  VolumeDescription& description = facts.description;
  description.size = read_size(header, path);
  const StoredType type = stored_type_of(header, path);
  note_bits(header, type, facts.warnings);
  take_stored_type(facts, type);
  facts.components = components_of(header, path);
  const bool may_be_whole = is_integer(description.type) || facts.wide.has_value();
  const bool is_color = !facts.components.channel_names.empty();
  if (header.intent == kIntentLabel && may_be_whole && !is_color) {
    description.kind = VolumeKind::labels;
  }
  description.rescale = read_rescale(header, path);
  facts.spacing_known = nifti_geometry(header, path, description.geometry, facts.warnings);
  for (Warning& warning : facts.warnings) warning.text += ": " + escaped(path);
  facts.place_known = header.sform_code > 0 || header.qform_code > 0;
  for (const auto& [name, text] : header.texts) facts.identity.note(name, text);
  const std::int64_t header_bytes = header.version == 1 ? 348 : 540;
  constexpr std::int64_t kFlagBytes = 4;  // which say whether an extension follows
  if (header.is_pair ? header.is_extended : header.voxel_offset > header_bytes + kFlagBytes) {
    facts.identity.note_lost("header extension");
  }
  settle(facts, options, path);

  VoxelRun run;
  run.path = voxel_file(path, header.is_pair);
  run.big_endian = header.big_endian;
  run.coding = is_gzip_file(run.path) ? StreamCoding::deflated : StreamCoding::plain;
  run.skip_bytes = voxel_start(header, path, header.is_pair ? 0 : header_bytes);
  take_component(header, facts, run);
  return make_streamed_source(std::move(facts), run);
}

}  // namespace octavo
