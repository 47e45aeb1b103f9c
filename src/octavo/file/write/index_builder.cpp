#include "octavo/file/write/index_builder.h"

#include <algorithm>

#include "octavo/core/crc32c.h"
#include "octavo/file/byte_codec.h"

namespace octavo {

namespace {

void put_range(ByteWriter& out, const ValueRange& range, std::int64_t& previous_min) {
  out.put_signed(range.min - previous_min);
  out.put_varint(static_cast<std::uint64_t>(range.max - range.min));
  previous_min = range.min;
}

}  // namespace

Bytes encode_root(const IndexRoot& root, const Levels& levels, const FileHeader& header) {
  Bytes bytes;
  ByteWriter out(bytes);
  out.put_varint(root.models.size());
  std::uint32_t slab = 0;
  for (const ModelRef& model : root.models) {
    out.put_varint(model.first_slab - slab);
    out.put_varint(model.length);
    out.put_u32(model.crc);
    slab = model.first_slab;
  }
  for (std::size_t t = 0; t < root.tiers.size(); ++t) {
    const TierIndex& tier = root.tiers[t];
    const auto pieces =
        static_cast<std::size_t>(piece_count(levels.tier_level_count(static_cast<int>(t))));
    std::int64_t previous_min = 0;
    for (std::size_t number = 0; number < tier.pages.size(); ++number) {
      const PageRef& page = tier.pages[number];
      if (t == 0 && tier.first_place(number) == 0) {
        out.put_varint(root.slab_trailer_bytes[static_cast<std::size_t>(tier.layer_of(number))]);
      }
      out.put_varint(page.length);
      out.put_u32(page.crc);
      put_range(out, page.range, previous_min);
      if (has_errors(header, static_cast<int>(t))) out.put_varint(page.error_steps);
      out.put_varint(page.uniform_count);
      for (std::size_t piece = 0; piece < pieces; ++piece) {
        out.put_varint(page.piece_start[piece]);
      }
    }
  }
  return bytes;
}

Bytes encode_page(const IndexPage& page) {
  Bytes bytes;
  ByteWriter out(bytes);
  out.put_u8(0);
  std::int64_t previous_min = 0;
  for (std::size_t i = 0; i < page.ranges.size(); ++i) {
    put_range(out, page.ranges[i], previous_min);
    if (!page.error_steps.empty()) out.put_varint(page.error_steps[i]);
  }
  const auto step = static_cast<std::size_t>(page.piece_count);
  for (std::size_t piece = 0; piece < step; ++piece) {
    for (std::size_t i = piece; i < page.pieces.size(); i += step) {
      out.put_varint(page.pieces[i].length);
    }
    for (std::size_t i = piece; i < page.pieces.size(); i += step) {
      if (page.pieces[i].length > 0) out.put_u32(page.pieces[i].crc);
    }
  }
  return bytes;
}

IndexBuilder::IndexBuilder(const Levels& levels, const FileHeader& header, Spool& spool,
                           std::size_t page_stream)
    : levels_(levels), header_(header), spool_(spool), page_stream_(page_stream) {
  for (int tier = 0; tier < levels.tier_count(); ++tier) {
    root_.tiers.push_back(make_tier_index(levels, tier));
  }
}

void IndexBuilder::add_brick(int tier_number, const ValueRange& range, std::uint64_t error_steps,
                             const std::vector<PieceRef>& pieces) {
  const TierIndex& tier = root_.tiers[static_cast<std::size_t>(tier_number)];
  page_.piece_count = piece_count(levels_.tier_level_count(tier_number));
  page_.ranges.push_back(range);
  if (has_errors(header_, tier_number)) page_.error_steps.push_back(error_steps);
  if (range.min != range.max) {
    page_.pieces.insert(page_.pieces.end(), pieces.begin(), pieces.end());
  }
  const auto count = static_cast<std::int64_t>(page_.ranges.size());
  if (count == tier.brick_count(tier.pages.size())) finish_page(tier_number);
}

void IndexBuilder::end_page(int tier) {
  if (!page_.ranges.empty()) finish_page(tier);
}

void IndexBuilder::finish_page(int tier_number) {
  TierIndex& tier = root_.tiers[static_cast<std::size_t>(tier_number)];
  const Bytes bytes = encode_page(page_);
  PageRef ref;
  ref.length = static_cast<std::uint32_t>(bytes.size());
  ref.crc = crc32c(bytes);
  ref.range = page_.ranges.front();
  for (const ValueRange& range : page_.ranges) {
    ref.range = {std::min(ref.range.min, range.min), std::max(ref.range.max, range.max)};
    if (range.min == range.max) ++ref.uniform_count;
  }
  for (const std::uint64_t steps : page_.error_steps) {
    ref.error_steps = std::max(ref.error_steps, steps);
  }
  const auto step = static_cast<std::size_t>(page_.piece_count);
  for (std::size_t i = 0; i < page_.pieces.size(); ++i) {
    ref.piece_start[i % step] += page_.pieces[i].length;
  }
  tier.pages.push_back(ref);
  spool_.append(page_stream_, bytes);
  page_ = {};
}

}  // namespace octavo
