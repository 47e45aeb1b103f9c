#include "octavo/io/volumes/raw_source.h"

#include <utility>

#include "octavo/core/checked.h"
#include "octavo/core/levels.h"
#include "octavo/core/text.h"
#include "octavo/io/source/byte_order.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/source/streamed_source.h"

namespace octavo {

namespace {

class RawPlaneFiles final : public IndexedPlaneSource {
 public:
  RawPlaneFiles(SourceFacts facts, std::vector<std::string> files, const RawLayout& layout)
      : IndexedPlaneSource(std::move(facts)), files_(std::move(files)), layout_(layout) {}

  void read_plane_at(std::int64_t z, std::span<std::byte> plane) const override {
    SourceFile(files_[static_cast<std::size_t>(z)]).read_exactly(layout_.header_bytes, plane);
    if (needs_swap(layout_.big_endian)) {
      swap_values(plane, static_cast<std::size_t>(bytes_per_voxel(layout_.type)));
    }
  }

 private:
  std::vector<std::string> files_;
  RawLayout layout_;
};

void check_length(const std::string& path, std::uint64_t needed, const std::string& what) {
  const std::uint64_t found = SourceFile(path).size();
  if (found == needed) return;
  throw Error(ErrorKind::source_rejected,
              what + " needs " + std::to_string(needed) + " bytes, the file has " +
                  std::to_string(found),
              path)
      .with_field("raw.size");
}

}  // namespace

std::unique_ptr<PlaneSource> open_raw_source(const std::vector<std::string>& files,
                                             const RawLayout& layout,
                                             const SourceOptions& options) {
  if (files.empty()) throw Error(ErrorKind::source_rejected, "no raw files found");
  SourceFacts facts;
  facts.format = "raw";
  facts.file_count = static_cast<std::int64_t>(files.size());
  facts.description.type = layout.type;
  facts.description.size = layout.size;
  settle_number_gaps(files, options, facts);
  settle(facts, options, files.front());
  const std::uint64_t plane = plane_bytes(facts.description);
  if (files.size() == 1) {
    const std::uint64_t voxels =
        checked_mul(plane, static_cast<std::uint64_t>(layout.size.z), "volume");
    check_length(files.front(), checked_add(layout.header_bytes, voxels, "file length"),
                 size_text(layout.size) + " " + std::string(voxel_type_name(layout.type)));
    return make_streamed_source(std::move(facts), {files.front(), layout.header_bytes, 0,
                                                   StreamCoding::plain, layout.big_endian});
  }
  if (files.size() != static_cast<std::size_t>(layout.size.z)) {
    throw Error(ErrorKind::source_rejected,
                "raw planes: " + std::to_string(layout.size.z) + " files expected, " +
                    std::to_string(files.size()) + " given");
  }
  for (const std::string& file : files) {
    check_length(file, layout.header_bytes + plane,
                 "a plane of " + size_text(layout.size.x, layout.size.y) + " " +
                     std::string(voxel_type_name(layout.type)));
  }
  return std::make_unique<RawPlaneFiles>(std::move(facts), files, layout);
}

}  // namespace octavo
