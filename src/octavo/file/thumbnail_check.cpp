#include "octavo/file/thumbnail_check.h"

#include <utility>

#include "octavo/file/reader.h"
#include "octavo/file/thumbnail.h"

namespace octavo {

std::optional<Damage> thumbnail_damage(const OpenFile& file, const Progress& watcher) {
  const PartEntry* const part = file.find_part(kThumbnailTag);
  if (part == nullptr) return std::nullopt;
  ReaderOptions options;
  options.watcher = &watcher;
  if (has_true_thumbnail(*FileReader::open(file.shared_source(), options))) return std::nullopt;
  Damage place;
  place.what = name_of(part->tag);
  place.code = static_cast<std::uint64_t>(part - file.parts().data());
  place.offset = part->bytes.offset;
  place.length = part->bytes.length;
  return damaged(std::move(place),
                 "is not the thumbnail of these voxels; no voxel depends on it");
}

}  // namespace octavo
