#include "octavo/file/index.h"

#include <algorithm>
#include <string>

#include "octavo/file/byte_codec.h"
#include "octavo/file/index_lengths.h"

namespace octavo {

namespace {

// Ranges stay inside the bounds at every step, so that no difference can overflow.
ValueRange take_range(ByteReader& in, const ValueRange& bounds, std::int64_t& previous_min) {
  const std::int64_t step = in.signed_varint();
  if (step < bounds.min - previous_min || step > bounds.max - previous_min) {
    in.fail("a smallest value outside the voxel type");
  }
  const std::int64_t min = previous_min + step;
  const std::uint64_t span = in.varint();
  if (span > static_cast<std::uint64_t>(bounds.max - min)) {
    in.fail("a largest value outside the voxel type");
  }
  previous_min = min;
  return {min, min + static_cast<std::int64_t>(span)};
}

std::int64_t page_count_of(const TierIndex& tier) { return tier.layer_pages * tier.grid.z; }

// No file is as long as what passes 64 bits.
std::uint64_t added(const ByteReader& in, std::uint64_t a, std::uint64_t b) {
  if (b > ~std::uint64_t{0} - a) in.fail("lengths beyond 64 bits");
  return a + b;
}

std::uint64_t take_bounded(ByteReader& in, std::uint64_t limit, const char* what) {
  const std::uint64_t value = in.varint();
  if (value > limit) in.fail(std::string(what) + " of " + std::to_string(value) + " bytes");
  return value;
}

// `last_slab` may be the one behind all: that of the model of the other tiers.
void parse_models(ByteReader& in, std::int64_t last_slab, IndexRoot& root) {
  const std::uint64_t count = in.varint();
  if (count == 0 || count - 1 > static_cast<std::uint64_t>(last_slab) || count > in.left() / 6) {
    in.fail(std::to_string(count) + " models");
  }
  root.models.reserve(count);
  std::uint64_t slab = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t step = in.varint();
    if (i == 0 ? step != 0 : step == 0 || step > static_cast<std::uint64_t>(last_slab) - slab) {
      in.fail("models out of order");
    }
    slab += step;
    ModelRef model;
    model.first_slab = static_cast<std::uint32_t>(slab);
    model.length = static_cast<std::uint32_t>(take_bounded(in, kMaxModelBytes, "a model"));
    model.crc = in.u32();
    root.models.push_back(model);
  }
}

// What all pages of a tier are parsed with.
struct TierRules {
  ValueRange bounds;
  std::uint64_t max_error_steps = 0;
  bool has_errors = false;
  int piece_count = 0;
  std::int64_t layer_planes = 0;
};

TierRules rules_of(const FileHeader& header, const Levels& levels, int tier) {
  return {header.description.coded_range(), max_error_steps(header),
          has_errors(header, tier), piece_count(levels.tier_level_count(tier)),
          levels.brick_side(tier).z};
}

std::uint64_t take_error(ByteReader& in, const TierRules& rules) {
  const std::uint64_t steps = in.varint();
  if (steps > rules.max_error_steps) in.fail("an error beyond the max error");
  return steps;
}

void parse_page_ref(ByteReader& in, const TierRules& rules, std::int64_t& previous_min,
                    TierIndex& tier) {
  PageRef ref;
  const std::size_t number = tier.pages.size();
  const std::int64_t bricks = tier.brick_count(number);
  const LengthBounds lengths = page_lengths(bricks);
  ref.length = static_cast<std::uint32_t>(take_bounded(in, lengths.max, "a page"));
  if (!lengths.holds(ref.length)) in.fail("a page too short for its bricks");
  ref.crc = in.u32();
  ref.range = take_range(in, rules.bounds, previous_min);
  if (rules.has_errors) ref.error_steps = take_error(in, rules);
  const std::uint64_t uniform = in.varint();
  if (uniform > static_cast<std::uint64_t>(bricks)) in.fail("more uniform bricks than bricks");
  ref.uniform_count = static_cast<std::uint32_t>(uniform);
  tier.uniform_count += static_cast<std::int64_t>(uniform);
  for (std::size_t piece = 0; piece < static_cast<std::size_t>(rules.piece_count); ++piece) {
    ref.piece_start[piece] = in.varint();
    tier.piece_bytes[piece] =
        added(in, tier.piece_bytes[piece], ref.piece_start[piece]);
  }
  tier.pages.push_back(ref);
}

void parse_tier(ByteReader& in, const TierRules& rules, int tier_number, IndexRoot& root) {
  TierIndex& tier = root.tiers.back();
  const auto page_count = static_cast<std::uint64_t>(page_count_of(tier));
  if (page_count > in.left() / kMinPageRefBytes) in.fail("ends early");
  tier.pages.reserve(page_count);
  if (tier_number == 0) root.slab_trailer_bytes.reserve(static_cast<std::size_t>(tier.grid.z));
  const std::uint64_t max_trailer_bytes =
      max_slab_trailer_bytes(tier.layer_bricks, rules.layer_planes);
  std::int64_t previous_min = 0;
  for (std::uint64_t page = 0; page < page_count; ++page) {
    if (tier_number == 0 && tier.first_place(page) == 0) {
      root.slab_trailer_bytes.push_back(
          static_cast<std::uint32_t>(take_bounded(in, max_trailer_bytes, "a slab trailer")));
    }
    parse_page_ref(in, rules, previous_min, tier);
  }
}

// Turns the total lengths of the pieces of one number, page by page, into offsets.
void place_pieces(TierIndex& tier, std::size_t piece, std::uint64_t& cursor,
                  const ByteReader& in) {
  for (PageRef& page : tier.pages) {
    const std::uint64_t bytes = page.piece_start[piece];
    page.piece_start[piece] = cursor;
    cursor = added(in, cursor, bytes);
  }
  tier.piece_end[piece] = cursor;
}

// The same for piece 0 of tier 0, which shares its slabs with models and slab trailers.
void place_slabs(IndexRoot& root, std::uint64_t& cursor, const ByteReader& in) {
  TierIndex& tier = root.tiers.front();
  auto model = root.models.begin();
  for (std::size_t number = 0; number < tier.pages.size(); ++number) {
    PageRef& page = tier.pages[number];
    const std::int64_t slab = tier.layer_of(number);
    if (tier.first_place(number) == 0 && model != root.models.end() && model->first_slab == slab) {
      model->offset = cursor;
      cursor = added(in, cursor, model->length);
      ++model;
    }
    const std::uint64_t bytes = page.piece_start[0];
    page.piece_start[0] = cursor;
    cursor = added(in, cursor, bytes);
    if (tier.first_place(number) + tier.brick_count(number) == tier.layer_bricks) {
      tier.piece_end[0] = cursor;
      cursor = added(in, cursor, root.slab_trailer_bytes[static_cast<std::size_t>(slab)]);
    }
  }
  if (model == root.models.end()) return;
  model->offset = cursor;
  cursor = added(in, cursor, model->length);
}

void place_pages(IndexRoot& root, const FileHeader& header, const ByteReader& in) {
  std::uint64_t cursor = header.pages.offset;
  for (TierIndex& tier : root.tiers) {
    for (PageRef& page : tier.pages) {
      page.offset = cursor;
      cursor += page.length;  // at most 2^48 pages of 64 KiB
    }
  }
  if (cursor != header.pages.end()) in.fail("pages do not fill their section");
}

}  // namespace

IndexRoot parse_root(ByteSpan bytes, const Levels& levels, const FileHeader& header) {
  ByteReader in(bytes, "index root");
  IndexRoot root;
  parse_models(in, levels.brick_grid(0).z - (levels.tier_count() > 1 ? 0 : 1), root);
  for (int tier = 0; tier < levels.tier_count(); ++tier) {
    root.tiers.push_back(make_tier_index(levels, tier));
    parse_tier(in, rules_of(header, levels, tier), tier, root);
  }
  in.expect_end();

  // Lengths become offsets; they must come out at the first page.
  std::uint64_t cursor = kHeaderBytes;
  place_slabs(root, cursor, in);
  for (int tier = 0; tier < levels.tier_count(); ++tier) {
    const int count = piece_count(levels.tier_level_count(tier));
    for (int piece = tier == 0 ? 1 : 0; piece < count; ++piece) {
      place_pieces(root.tiers[static_cast<std::size_t>(tier)], static_cast<std::size_t>(piece),
                   cursor, in);
    }
  }
  if (cursor != header.pages.offset) in.fail("pieces do not fill the data of the file");
  place_pages(root, header, in);
  return root;
}

IndexPage parse_page(ByteSpan bytes, const IndexRoot& root, const Levels& levels, int tier_number,
                     std::size_t number, const FileHeader& header) {
  const TierIndex& tier = root.tiers[static_cast<std::size_t>(tier_number)];
  const PageRef& ref = tier.pages[number];
  const auto count = static_cast<std::size_t>(tier.brick_count(number));
  // Flags, and a length that can hold the bricks
  ByteReader in(bytes, "index page");
  const std::uint8_t flags = in.u8();
  if (flags != 0) {
    throw Error(ErrorKind::unsupported_version, "index page: flags " + std::to_string(flags) +
                                                    ", which this program does not know");
  }
  if (in.left() / 2 < count) in.fail("ends early");

  // Ranges and errors: equal ends mark a uniform brick.
  IndexPage page;
  const TierRules rules = rules_of(header, levels, tier_number);
  page.piece_count = rules.piece_count;
  std::int64_t previous_min = 0;
  std::uint32_t slot_count = 0;
  std::uint64_t error_steps = 0;
  ValueRange all = {rules.bounds.max, rules.bounds.min};
  for (std::size_t i = 0; i < count; ++i) {
    const ValueRange range = take_range(in, rules.bounds, previous_min);
    if (rules.has_errors) {
      page.error_steps.push_back(take_error(in, rules));
      error_steps = std::max(error_steps, page.error_steps.back());
    }
    page.ranges.push_back(range);
    page.slots.push_back(slot_count);
    if (range.min != range.max) ++slot_count;
    all = {std::min(all.min, range.min), std::max(all.max, range.max)};
  }
  if (all != ref.range || error_steps != ref.error_steps ||
      count - slot_count != ref.uniform_count) {
    in.fail("contradicts the index root");
  }

  // Pieces: lengths of those of a number, then checksums of those that are not empty.
  const auto step = static_cast<std::size_t>(page.piece_count);
  page.pieces.resize(slot_count * step);
  for (std::size_t piece = 0; piece < step; ++piece) {
    std::uint64_t cursor = ref.piece_start[piece];
    for (std::size_t i = piece; i < page.pieces.size(); i += step) {
      page.pieces[i].offset = cursor;
      page.pieces[i].length =
          static_cast<std::uint32_t>(take_bounded(in, kMaxPieceBytes, "a piece"));
      cursor += page.pieces[i].length;
    }
    if (cursor != root.piece_end(tier_number, number, static_cast<int>(piece))) {
      in.fail("contradicts the index root");
    }
    for (std::size_t i = piece; i < page.pieces.size(); i += step) {
      if (page.pieces[i].length > 0) page.pieces[i].crc = in.u32();
    }
  }
  in.expect_end();
  return page;
}

}  // namespace octavo
