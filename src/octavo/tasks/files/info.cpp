#include "octavo/tasks/files/info.h"

#include <filesystem>

#include "octavo/core/error.h"
#include "octavo/core/place_known.h"
#include "octavo/file/directory.h"
#include "octavo/file/layout.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/file/thumbnail.h"
#include "octavo/tasks/files/finite_voxels.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

std::uint64_t metadata_offset_of(const ByteSource& source) {
  HeaderBlock block{};
  source.read(0, block);
  return parse_header(block, source.size()).metadata.offset;
}

PartInfo info_of(const PartEntry& part) {
  return {{part.tag.begin(), part.tag.end()},
          (part.flags & kRequiredPart) != 0,
          (part.flags & kVoxelPart) != 0,
          (part.flags & kRestPart) != 0,
          part.bytes.length,
          is_known(part.tag)};
}

void require_picture(const Output& output, const std::string& input) {
  std::error_code none;
  if (is_octavo_path(output.path) || std::filesystem::equivalent(output.path, input, none)) {
    throw Error(ErrorKind::invalid_argument, "is no name of a picture", output.path)
        .with_field("thumbnail");
  }
  require_free(output);
}

void write_thumbnail(const FileReader& reader, const Output& output) {
  const bool has_one = reader.thumbnail_bytes() > 0;
  PendingFile file(local_storage(), output.path);
  file.append(has_one ? reader.thumbnail() : thumbnail_of(reader));
  file.seal();
  file.publish(output.overwrite);
}

}  // namespace

InfoResult info(const InfoOptions& options, const TaskContext& context) {
  TaskContext any_size = context;
  any_size.max_voxels = 0;  // no voxel is read, or one plane of a coarse level
  const bool wants_thumbnail = !options.thumbnail.path.empty();
  if (wants_thumbnail) require_picture(options.thumbnail, options.input);
  const auto reader = open_volume(options.input, any_size);
  if (wants_thumbnail) write_thumbnail(*reader, options.thumbnail);
  InfoResult result;
  result.name = reader->source().name();
  result.format_version = reader->format_version();
  result.volume = reader->description();
  for (int level = 0; level < reader->levels().count(); ++level) {
    const Geometry geometry = reader->levels().geometry(result.volume.geometry, level);
    result.levels.push_back(
        {reader->levels().size(level), geometry.spacing_mm, reader->level_summary(level)});
  }
  result.file_bytes = reader->file_bytes();
  result.raw_bytes = raw_bytes_of(result.volume);
  result.range = reader->range();
  result.has_values = has_finite_voxels(*reader);
  result.max_error = reader->max_error();
  result.achieved_error = reader->achieved_error();
  result.detail_level = reader->detail_level();
  if (result.detail_level > 0) {
    result.detail_errors =
        result.volume.metadata.facts().coding.value_or(CodingNote{}).detail_errors;
  }
  result.voxel_digest = reader->voxel_digest();
  result.is_place_known = is_place_known(result.volume);
  result.thumbnail_bytes = reader->thumbnail_bytes();
  for (const PartEntry& part : reader->parts()) result.parts.push_back(info_of(part));
  for (const UnknownExtension& extension : reader->unknown_extensions()) {
    result.unknown_extensions.push_back({extension.tag, extension.length});
  }
  result.metadata_offset = metadata_offset_of(reader->source());
  return result;
}

}  // namespace octavo
