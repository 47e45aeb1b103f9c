#include "octavo/io/volumes/raw_source.h"

#include <charconv>
#include <utility>

#include "octavo/core/checked.h"
#include "octavo/core/levels.h"
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
                  std::to_string(found) + "; check the numbers of --raw",
              path);
}

std::int64_t parse_count(std::string_view text, const std::string& whole) {
  std::int64_t value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure == std::errc() && end == text.data() + text.size() && value >= 1 &&
      value <= kMaxAxis) {
    return value;
  }
  throw Error(ErrorKind::invalid_argument,
              "raw layout \"" + escaped(whole) + "\": \"" + escaped(text) +
                  "\" is not a size; write nx,ny,nz,type, for example 512,512,300,int16");
}

}  // namespace

RawLayout parse_raw_layout(const std::string& text) {
  std::vector<std::string_view> parts;
  for (std::string_view rest = text;;) {
    const std::size_t comma = rest.find(',');
    parts.push_back(rest.substr(0, comma));
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (parts.size() != 4) {
    throw Error(ErrorKind::invalid_argument,
                "raw layout \"" + escaped(text) + "\": 4 parts expected, " +
                    std::to_string(parts.size()) + " found; write nx,ny,nz,type");
  }
  RawLayout layout;
  layout.size = {parse_count(parts[0], text), parse_count(parts[1], text),
                 parse_count(parts[2], text)};
  std::string_view type = parts[3];
  if (type.ends_with(":be") || type.ends_with(":le")) {
    layout.big_endian = type.ends_with(":be");
    type.remove_suffix(3);
  }
  const std::optional<VoxelType> known = parse_voxel_type(type);
  if (!known) {
    throw Error(ErrorKind::invalid_argument,
                "raw layout \"" + escaped(text) + "\": unknown type \"" + escaped(type) +
                    "\"; int8, uint8, int16, uint16, int32, uint32 or float32");
  }
  layout.type = *known;
  return layout;
}

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
