#include "octavo/io/volumes/gipl_source.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "octavo/core/checked.h"
#include "octavo/io/source/header_bytes.h"
#include "octavo/io/source/header_text.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/source/streamed_source.h"

namespace octavo {

namespace {

constexpr std::size_t kGiplHeaderBytes = 256;
constexpr std::uint32_t kMagic = 719555000;
constexpr std::uint32_t kOlderMagic = 4026526128;
constexpr std::uint32_t kExtendedMagic = 815;

struct GiplHeader {
  std::array<std::int64_t, 4> dims{};
  int image_type = 0;
  std::array<double, 4> pixdim_mm{};
  std::array<double, 4> origin_mm{};
  std::string text;
  std::uint32_t magic = 0;
};

StreamCoding coding_of(const std::string& path) {
  return is_gzip_file(path) ? StreamCoding::deflated : StreamCoding::plain;
}

/// The header as it stands there; nothing of it is proven yet but that it is whole.
GiplHeader read_header(const std::string& path) {
  const StreamCoding coding = coding_of(path);
  const std::uint64_t file_bytes = SourceFile(path).size();
  if (coding == StreamCoding::plain && file_bytes < kGiplHeaderBytes) {
    reject(path, "not a GIPL file: its header alone takes 256 bytes, the file has " +
                     std::to_string(file_bytes) +
                     "; check what it is, or copy it again from its origin");
  }
  std::array<std::byte, kGiplHeaderBytes> bytes{};
  VoxelStream(path, 0, coding).read(bytes);
  const HeaderBytes read(bytes, true);
  GiplHeader header;
  read.fill<std::uint16_t>(0, header.dims);
  header.image_type = read.at<std::uint16_t>(8);
  read.fill<float>(10, header.pixdim_mm);
  header.text = std::string(trimmed(read.text(26, 80)));
  read.fill<double>(204, header.origin_mm);
  header.magic = read.at<std::uint32_t>(252);
  return header;
}

void require_magic(const GiplHeader& header, const std::string& path) {
  if (header.magic == kMagic || header.magic == kOlderMagic) return;
  if (header.magic == kExtendedMagic) {
    reject(path, "an extended GIPL file (magic number 815) with axes of its own, which is not "
                 "read; convert it to NIfTI");
  }
  reject(path, "not a GIPL file: its magic number at byte 252 is " + std::to_string(header.magic) +
                   ", 719555000 or 4026526128 expected; check what it is, or copy it again from "
                   "its origin");
}

std::string type_name(int image_type) {
  static const std::map<int, std::string> kNames = {
      {66, "vectors"},           {67, "vectors"},
      {68, "vectors"},            {69, "vectors"},           {144, "complex 16 bit"},
      {160, "complex 32 bit"},    {192, "complex float 32 bit"}, {193, "complex float 64 bit"},
      {200, "surface"},           {201, "polygon"}};
  const auto found = kNames.find(image_type);
  const std::string code = "type code " + std::to_string(image_type);
  return found == kNames.end() ? code : found->second + " (" + code + ")";
}

StoredType stored_type_of(const GiplHeader& header, const std::string& path) {
  // Binary pictures (1) have a byte for each voxel.
  static const std::map<int, StoredType> kTypes = {
      {1, VoxelType::uint8},   {7, VoxelType::int8},    {8, VoxelType::uint8},
      {15, VoxelType::int16},  {16, VoxelType::uint16}, {31, VoxelType::uint32},
      {32, VoxelType::int32},  {64, VoxelType::float32},
      {65, WideType::float64}};
  const auto found = kTypes.find(header.image_type);
  if (found != kTypes.end()) return found->second;
  reject(path, "voxels of " + type_name(header.image_type) +
                   " are not read; integers of 8, 16 or 32 bits and float of 32 or 64 bits are. "
                   "Convert it to one of these first");
}

/// A picture of two dimensions has no third length, or 1.
Size3 read_size(const GiplHeader& header, const std::string& path) {
  const auto& [x, y, z, t] = header.dims;
  if (x > 0 && y > 0 && (z > 0 || t <= 1)) return {x, y, std::max<std::int64_t>(z, 1)};
  reject(path, "the lengths of its axes are " + std::to_string(x) + ", " + std::to_string(y) +
                   ", " + std::to_string(z) + ", " + std::to_string(t) +
                   ": an axis without length in between holds no voxels; the header is damaged");
}

Geometry read_geometry(const GiplHeader& header) {
  Geometry geometry;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (header.dims[axis] == 0) continue;
    geometry.spacing_mm[axis] = header.pixdim_mm[axis];
    geometry.origin_mm[axis] = header.origin_mm[axis];
  }
  return geometry;
}

}  // namespace

std::unique_ptr<PlaneSource> open_gipl_source(const std::string& path,
                                              const SourceOptions& options) {
  const GiplHeader header = read_header(path);
  require_magic(header, path);
  SourceFacts facts;
  facts.format = "GIPL";
  facts.description.size = read_size(header, path);
  take_stored_type(facts, stored_type_of(header, path));
  facts.description.geometry = read_geometry(header);
  facts.spacing_known = true;
  facts.components.times = std::max<std::int64_t>(header.dims[3], 1);
  facts.identity.note("text", header.text);
  settle(facts, options, path);

  VoxelRun run;
  run.path = path;
  run.coding = coding_of(path);
  run.skip_bytes = kGiplHeaderBytes;
  run.big_endian = true;
  const std::uint64_t volume_bytes =
      checked_mul(stored_plane_bytes(facts),
                  static_cast<std::uint64_t>(facts.description.size.z), "volume");
  run.take_volume(facts.choice.time, facts.components.times, volume_bytes);
  return make_streamed_source(std::move(facts), run);
}

}  // namespace octavo
