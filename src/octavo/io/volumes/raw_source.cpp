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

/// The stored numbers of one plane, in native byte order.
void read_stored(const std::string& path, const RawLayout& layout, std::span<std::byte> numbers) {
  SourceFile(path).read_exactly(layout.header_bytes, numbers);
  if (needs_swap(layout.big_endian)) swap_values(numbers, bytes_per_value(layout.type));
}

class RawPlaneFiles final : public IndexedPlaneSource {
 public:
  RawPlaneFiles(SourceFacts facts, std::vector<std::string> files, const RawLayout& layout)
      : IndexedPlaneSource(std::move(facts)), files_(std::move(files)), layout_(layout) {}

  void read_plane_at(std::int64_t z, std::span<std::byte> plane) const override {
    const std::string& path = files_[static_cast<std::size_t>(z)];
    if (!narrowing()) return read_stored(path, layout_, plane);
    std::vector<std::byte> wide(plane.size() / bytes_per_value(narrowing()->to) *
                                bytes_per_value(narrowing()->from));
    read_stored(path, layout_, wide);
    narrow(*narrowing(), wide, plane, {path, layout_.size.x, z, 0});
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
  take_stored_type(facts, layout.type);
  facts.description.size = layout.size;
  settle_number_gaps(files, options, facts);
  settle(facts, options, files.front());
  const std::uint64_t plane = stored_plane_bytes(facts);
  if (files.size() == 1) {
    const std::uint64_t voxels =
        checked_mul(plane, static_cast<std::uint64_t>(layout.size.z), "volume");
    check_length(files.front(), checked_add(layout.header_bytes, voxels, "file length"),
                 size_text(layout.size) + " " + std::string(stored_type_name(layout.type)));
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
                     std::string(stored_type_name(layout.type)));
  }
  facts.files = files_of_slices(files);
  if (!facts.wide) facts.files.outline = outline_of_slices(facts.files);
  settle_narrowing(facts, [&](std::int64_t z, std::span<std::byte> numbers) {
    read_stored(files[static_cast<std::size_t>(z)], layout, numbers);
  });
  return std::make_unique<RawPlaneFiles>(std::move(facts), files, layout);
}

}  // namespace octavo
