// The small streams of grey bricks and their models, each of arbitrary bytes: what is read and
// written again reads as before.
//
//     u8 stream, then:
//     0 list of parts          u8 parts | bytes
//     1 flags of cells         3 u8 size | bytes
//     2 corrections            3 u8 size | bytes
//     3 map of values          map | i32, i32 range of a brick | map of the brick
//     4 model                  u8 type | u8 finest level with details | bytes

#include <algorithm>

#include "fuzz/brick_input.h"
#include "octavo/codec/grey/grey_brick.h"
#include "octavo/codec/grey/grey_corrections.h"

namespace {

using namespace octavo;
using namespace octavo::grey;
using fuzz::require;

Size3 take_size(fuzz::Input& input) {
  Size3 size;
  for (int axis = 0; axis < 3; ++axis) size[axis] = 1 + input.take<std::uint8_t>() % 16;
  return size;
}

void check_part_list(fuzz::Input& input) {
  const auto count = input.take<std::uint8_t>();
  const Bytes bytes = input.take_bytes(input.left());
  ByteSpan left = bytes;
  const std::vector<PartBytes> parts = take_part_list(left, count);
  Bytes again;
  put_part_list(again, parts);
  require(std::ranges::equal(again, ByteSpan(bytes).first(bytes.size() - left.size())),
          "another list of parts");
}

void check_cells(fuzz::Input& input) {
  const Size3 size = take_size(input);
  const UniformCells cells = decode_cells(input.take_bytes(input.left()), size);
  require(decode_cells(encode_cells(cells), size).flags == cells.flags, "other cells");
}

void check_corrections(fuzz::Input& input) {
  const Size3 size = take_size(input);
  const Corrections corrections = decode_corrections(input.take_bytes(input.left()), size);
  require(decode_corrections(encode_corrections(corrections, size), size) == corrections,
          "other corrections");
}

void require_same(const ValueMap& a, const ValueMap& b) {
  require(a.lattice.step == b.lattice.step && a.lattice.offset == b.lattice.offset &&
              a.first == b.first && a.used == b.used,
          "another map of values");
}

/// Every mean has a detail, and the samples that the gaps leave are those that occur.
void check_gaps(const ValueMap& map, const BrickMap& brick, const ValueRange& codes) {
  for (const int rounding : {0, 1}) {
    const ValueGaps gaps = make_gaps(map, brick, codes, 0, rounding);
    for (std::int64_t mean = -1; mean <= codes.max - codes.min + 1; ++mean) {
      const ValueGaps::Details& details = gaps.of(mean);
      for (std::int64_t number = -1; number <= details.last + 1; ++number) {
        const int detail = details.detail(number);
        const auto nearest = static_cast<std::int64_t>(details.nearest(detail));
        require(nearest == std::clamp<std::int64_t>(number, 0, details.last),
                "a detail with another number");
      }
    }
  }
}

void check_value_map(fuzz::Input& input) {
  const Bytes bytes = input.take_bytes(input.left());
  ByteSpan left = bytes;
  const ValueMap map = take_value_map(left);
  Bytes again;
  put_value_map(again, map);
  ByteSpan reread = again;
  require_same(take_value_map(reread), map);
  require(reread.empty(), "a map of values of another length");

  fuzz::Input rest(left.data(), left.size());
  const auto a = rest.take<std::int32_t>();
  const auto b = rest.take<std::int32_t>();
  const ValueRange range{std::min(a, b), std::max(a, b)};
  const Bytes brick_bytes = rest.take_bytes(rest.left());
  ByteSpan brick_left = brick_bytes;
  const BrickMap brick = take_brick_map(map, range, brick_left);
  Bytes brick_again;
  put_brick_map(brick_again, brick);
  require(std::ranges::equal(
              brick_again, ByteSpan(brick_bytes).first(brick_bytes.size() - brick_left.size())),
          "another map of a brick");
  const CodeScale scale = brick.scale(map);
  const ValueRange codes{scale.code_of(range.min), scale.code_of(range.max)};
  if (brick.has_gaps) check_gaps(map, brick, codes);
}

void check_model(fuzz::Input& input) {
  const VoxelType type = fuzz::kTypes[input.take<std::uint8_t>() % fuzz::kTypes.size()];
  const int detail_level = input.take<std::uint8_t>() % kTierLevels;
  const auto codec = parse_grey_model(type, input.take_bytes(input.left()), detail_level);
  const Bytes bytes = codec->serialized();
  require(parse_grey_model(type, bytes, detail_level)->serialized() == bytes, "another model");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr void (*kStreams[])(fuzz::Input&) = {check_part_list, check_cells, check_corrections,
                                                check_value_map, check_model};
  fuzz::Input input(data, size);
  const auto stream = input.take<std::uint8_t>() % std::size(kStreams);
  fuzz::expect_error_or_success([&] { kStreams[stream](input); });
  return 0;
}
