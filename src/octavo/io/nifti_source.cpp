#include "octavo/io/nifti_source.h"

#include <cmath>
#include <map>
#include <utility>

#include "octavo/io/nifti_header.h"
#include "octavo/io/source_file.h"
#include "octavo/io/streamed_source.h"

namespace octavo {

namespace {

constexpr std::int64_t kIntentLabel = 1002;

[[noreturn]] void reject(const std::string& path, const std::string& why) {
  throw Error(ErrorKind::source_rejected, why, path);
}

VoxelType voxel_type_of(const NiftiHeader& header, const std::string& path) {
  static const std::map<std::int64_t, VoxelType> kTypes = {
      {2, VoxelType::uint8},   {4, VoxelType::int16},    {8, VoxelType::int32},
      {16, VoxelType::float32}, {256, VoxelType::int8},  {512, VoxelType::uint16},
      {768, VoxelType::uint32}};
  const auto found = kTypes.find(header.datatype);
  if (found == kTypes.end()) {
    reject(path, "voxels of " + nifti_type_name(header.datatype) +
                     " are not read; integers of 8, 16 or 32 bits and float 32 bit are");
  }
  return found->second;
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
    } else if (length > 1) {
      reject(path, std::to_string(length) + (axis == 3 ? " volumes in time" : " values per voxel") +
                       std::string(" (axis ") + std::to_string(axis + 1) +
                       "): one volume is read; take out one first");
    }
  }
  return size;
}

Rescale read_rescale(const NiftiHeader& header) {
  // A slope of 0 says that there is no scaling (NIfTI-1, "Data scaling").
  if (header.slope == 0 || !std::isfinite(header.slope)) return {};
  return {header.slope, std::isfinite(header.intercept) ? header.intercept : 0.0};
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

}  // namespace

std::unique_ptr<PlaneSource> open_nifti_source(const std::string& path,
                                               const SourceOptions& options) {
  const NiftiHeader header = read_nifti_header(path);
  SourceFacts facts;
  facts.format = "NIfTI-" + std::to_string(header.version);
  facts.file_count = header.is_pair ? 2 : 1;
  VolumeDescription& description = facts.description;
  description.size = read_size(header, path);
  description.type = voxel_type_of(header, path);
  description.rescale = read_rescale(header);
  if (header.intent == kIntentLabel && is_integer(description.type)) {
    description.kind = VolumeKind::labels;
  }
  std::string note;
  facts.spacing_known = nifti_geometry(header, description.geometry, note);
  for (const auto& [name, text] : header.texts) facts.identity.note(name, text);
  const std::int64_t plain_offset = header.version == 1 ? 352 : 544;
  if (!header.is_pair && header.voxel_offset > plain_offset) {
    facts.identity.note_lost("header extension");
  }
  if (!note.empty()) facts.warnings.push_back(note + ": " + escaped(path));
  settle(facts, options, path);

  VoxelRun run;
  run.path = voxel_file(path, header.is_pair);
  run.big_endian = header.big_endian;
  run.coding = is_gzip_file(run.path) ? StreamCoding::deflated : StreamCoding::plain;
  const std::int64_t least = header.is_pair ? 0 : header.version == 1 ? 348 : 540;
  if (header.voxel_offset < least) {
    reject(path, "the voxels are said to start at byte " + std::to_string(header.voxel_offset) +
                     ", inside the header of " + std::to_string(least) + " bytes");
  }
  run.skip_bytes = static_cast<std::uint64_t>(header.voxel_offset);
  return make_streamed_source(std::move(facts), run);
}

}  // namespace octavo
