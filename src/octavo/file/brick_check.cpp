#include "octavo/file/brick_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>

#include "octavo/codec/exact/float_bins.h"

namespace octavo {

namespace {

using Segments = std::span<const ByteSpan>;

// Whether the finite ones of `count` floats lie between the voxels that codes stand for.
bool are_bounded(const VolumeDescription& volume, const ValueRange& codes, const void* voxels,
                 std::int64_t count) {
  const double low = volume.voxel_of(codes.min);
  const double high = volume.voxel_of(codes.max);
  const float* const first = static_cast<const float*>(voxels);
  return std::all_of(first, first + count, [&](float v) {
    return !std::isfinite(v) || (v >= low && v <= high);
  });
}

// Smallest and largest of `count` voxels.
ValueRange range_of_voxels(VoxelType type, const void* voxels, std::int64_t count) {
  return with_voxel_type(type, [&](auto tag) -> ValueRange {
    using T = typename decltype(tag)::type;
    const T* first = static_cast<const T*>(voxels);
    const auto [low, high] = std::minmax_element(first, first + count);
    return {static_cast<std::int64_t>(*low), static_cast<std::int64_t>(*high)};
  });
}

// What is wrong with the range that the index has of a brick; nothing where it is that of the
// voxels.
std::optional<std::string> range_problem(const OpenFile& file, const BrickEntry& entry,
                                         const void* voxels, std::int64_t count) {
  const VolumeDescription& volume = file.description();
  const VoxelType type = volume.codec_type();
  if (!is_integer(type)) {
    if (are_bounded(volume, entry.range, voxels, count)) return std::nullopt;
    return "its voxels lie outside the range in the index";
  }
  const ValueRange found = range_of_voxels(type, voxels, count);
  const bool is_inside = found.min >= entry.range.min && found.max <= entry.range.max;
  // With a max error the index may hold bounds that are wider than the voxels.
  const bool may_be_wider = has_errors(file.header(), entry.tier);
  if (found == entry.range || (may_be_wider && is_inside)) return std::nullopt;
  return "its voxels have another range than the index says";
}

// Level 0 of a brick, dense [z][y][x]. One with parts is decoded part by part, so that the checksum
// of each, for readers of one part alone, is proven as well.
void decode_finest(const BrickCodec& codec, const BrickShape& shape, VoxelType type,
                   const BrickEntry& entry, Segments segments, Bytes& voxels) {
  const auto parts = codec.open_parts(shape, type, entry.range, segments);
  if (!parts) {
    codec.decode(shape, type, entry.range, segments, 0, voxels.data());
    return;
  }
  const Size3& size = shape.size.front();
  ByteSpan left = segments.front();
  for (std::size_t i = 0; i < parts->parts().size(); ++i) {
    const BrickParts::Part& part = parts->parts()[i];
    if (part.length > left.size()) throw Error(ErrorKind::corrupt, "a part ends too late");
    const Index3& at = part.box.lo;
    const std::int64_t first = (at.z * size.y + at.y) * size.x + at.x;
    parts->decode(i, left.first(part.length),
                  {voxels.data() + first * bytes_per_voxel(type), size.x, size.x * size.y});
    left = left.subspan(part.length);
  }
  if (!left.empty()) throw Error(ErrorKind::corrupt, "bytes behind the parts of a brick");
}

// Of a stored brick, and of the coarsest level of a grey one, a piece holds voxels as they are.
OtherProof proof_of(const OpenFile& file, const BrickEntry& entry, std::size_t piece) {
  const std::size_t last = entry.pieces.size() - 1;
  const bool is_stored = last > 0 && entry.pieces.back().length == 0;
  const bool is_coarsest = piece == last &&
                           file.levels().tier_level_count(entry.tier) <= kTierPieces &&
                           file.description().kind == VolumeKind::grey;
  // Of exact floats most bits are plain, and decoding takes them for what they are.
  const bool has_places = entry.tier == 0 && piece == 0 &&
                          file.description().codec_type() == VoxelType::float32;
  return is_stored || is_coarsest || has_places ? OtherProof::range : OtherProof::content;
}

// Reads the pieces of a brick and proves their checksums.
std::vector<Damage> read_pieces(const OpenFile& file, const BrickEntry& entry,
                                std::array<Bytes, kTierPieces>& pieces) {
  std::vector<Damage> damages;
  for (std::size_t i = 0; i < entry.pieces.size(); ++i) {
    const BrickEntry::StoredPiece& piece = entry.pieces[i];
    if (piece.length == 0) continue;
    Damage place = brick_place(entry, static_cast<int>(i));
    place.proof = proof_of(file, entry, i);
    pieces[i] = read_arriving(file.source(), piece.offset, piece.length);
    const std::uint32_t found =
        piece_crc(file.header().build_id, place.level, entry.code, pieces[i]);
    if (auto damage = checksum_damage(place, found, piece.crc)) damages.push_back(*damage);
  }
  return damages;
}

}  // namespace

Damage brick_place(const BrickEntry& entry, int piece) {
  const BrickEntry::StoredPiece& stored = entry.pieces[static_cast<std::size_t>(piece)];
  Damage place;
  place.what = "brick";
  place.tier = entry.tier;
  place.brick = entry.brick;
  place.code = entry.code;
  place.level = Levels::first_level(entry.tier) + piece;
  place.offset = stored.offset;
  place.length = stored.length;
  return place;
}

std::int64_t uniform_parent(const VolumeDescription& volume, std::int64_t code) {
  if (is_integer(volume.codec_type())) return code;
  return exact::bits_of(volume.coding->voxel_of(code));
}

CheckedBrick check_brick(const OpenFile& file, const BrickEntry& entry, const BrickCheck& check) {
  const VolumeDescription& volume = file.description();
  const bool has_parent = check.decodes && entry.tier + 1 < file.levels().tier_count();
  CheckedBrick checked;
  if (entry.is_uniform()) {
    if (check.planes != nullptr) check.planes->put_uniform(entry.brick, entry.range.min);
    if (has_parent) checked.parent = uniform_parent(volume, entry.range.min);
    return checked;
  }
  std::array<Bytes, kTierPieces> pieces;
  checked.damages = read_pieces(file, entry, pieces);
  if (!checked.damages.empty() || !check.decodes) return checked;

  const BrickShape shape = brick_shape(file.levels(), entry.tier, entry.brick);
  const VoxelType type = volume.codec_type();
  const std::int64_t count = shape.size.front().voxel_count();
  Bytes voxels(static_cast<std::size_t>(count * bytes_per_voxel(type)));
  try {
    const auto all = segments_of(std::span<const Bytes>(pieces).first(entry.pieces.size()),
                                 shape.level_count);
    const auto segments = Segments(all).first(static_cast<std::size_t>(shape.level_count));
    const auto codec = file.codec(entry.model);
    decode_finest(*codec, shape, type, entry, segments, voxels);
    if (has_parent) checked.parent = codec->decode_parent(shape, type, entry.range, segments);
  } catch (const Error& error) {
    require_damage(error);
    checked.damages.push_back(damaged(brick_place(entry, 0), error.detail()));
    return checked;
  }
  if (check.planes != nullptr) check.planes->put(entry.brick, voxels.data());
  if (const auto problem = range_problem(file, entry, voxels.data(), count)) {
    checked.damages.push_back(damaged(brick_place(entry, 0), *problem));
    checked.parent.reset();
  }
  return checked;
}

std::vector<std::int64_t> parents_in(const OpenFile& file, const BrickEntry& entry) {
  const VolumeDescription& volume = file.description();
  const BrickShape shape = brick_shape(file.levels(), entry.tier, entry.brick);
  const auto count = static_cast<std::size_t>(shape.size.front().voxel_count());
  if (entry.is_uniform()) {
    return std::vector<std::int64_t>(count, uniform_parent(volume, entry.range.min));
  }
  const VoxelType type = volume.codec_type();
  Bytes voxels(count * static_cast<std::size_t>(bytes_per_voxel(type)));
  const BrickBytes bytes = file.read_segments(entry, 0);
  const auto segments =
      Segments(bytes.segments).first(static_cast<std::size_t>(shape.level_count));
  file.codec(entry.model)->decode(shape, type, entry.range, segments, 0, voxels.data());
  // Floats are compared bit by bit
  return with_voxel_type(is_integer(type) ? type : VoxelType::uint32, [&](auto tag) {
    using T = typename decltype(tag)::type;
    const T* const first = reinterpret_cast<const T*>(voxels.data());
    return std::vector<std::int64_t>(first, first + count);
  });
}

bool are_read_alike(const VolumeDescription& volume, std::int64_t a, std::int64_t b) {
  if (a == b) return true;
  return volume.coding && !volume.coding->is_exact && volume.voxel_of(a) == volume.voxel_of(b);
}

std::string sample_text(const VolumeDescription& volume, std::int64_t parent) {
  if (!volume.coding) return std::to_string(parent);
  const float voxel = is_integer(volume.codec_type())
                          ? volume.coding->voxel_of(parent)
                          : exact::float_of_bits(static_cast<std::uint32_t>(parent));
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", static_cast<double>(voxel));
  return text;
}

}  // namespace octavo
