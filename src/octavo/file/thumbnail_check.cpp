#include "octavo/file/thumbnail_check.h"

#include <string>

#include "octavo/file/reader.h"
#include "octavo/file/thumbnail.h"

namespace octavo {

std::optional<Damage> thumbnail_damage(const OpenFile& file, const Progress& watcher) {
  const PartEntry* const part = file.find_part(kThumbnailTag);
  if (part == nullptr) return std::nullopt;
  ReaderOptions options;
  options.watcher = &watcher;
  if (has_true_thumbnail(*FileReader::open(file.shared_source(), options))) return std::nullopt;
  Damage damage;
  damage.what = "part";
  damage.code = static_cast<std::uint64_t>(part - file.parts().data());
  damage.offset = part->bytes.offset;
  damage.length = part->bytes.length;
  damage.detail = name_of(part->tag) + " at byte " + std::to_string(damage.offset) +
                  ": is not the thumbnail of these voxels; no voxel depends on it";
  return damage;
}

}  // namespace octavo
