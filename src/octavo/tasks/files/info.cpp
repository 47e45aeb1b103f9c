#include "octavo/tasks/files/info.h"

#include "octavo/file/layout.h"
#include "octavo/io/source/place_known.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

std::uint64_t metadata_offset_of(const ByteSource& source) {
  HeaderBlock block{};
  source.read(0, block);
  return parse_header(block, source.size()).metadata.offset;
}

}  // namespace

InfoResult info(const InfoOptions& options, const TaskContext& context) {
  TaskContext any_size = context;
  any_size.max_voxels = 0;  // no voxel is read
  const auto reader = open_volume(options.input, any_size);
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
  result.max_error = reader->max_error();
  result.achieved_error = reader->achieved_error();
  result.voxel_digest = reader->voxel_digest();
  result.is_place_known = is_place_known(result.volume);
  result.metadata_offset = metadata_offset_of(reader->source());
  return result;
}

}  // namespace octavo
