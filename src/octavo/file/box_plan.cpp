#include "octavo/file/box_plan.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/core/error.h"

namespace octavo {

namespace {

/// More than the list of the parts of a brick can take.
constexpr std::uint64_t kPartListBytes = 256;

/// What is needed of bricks of which it is not known yet where their parts are.
enum class UnknownParts { list, brick };

/// At most so much of level 0 of a brick is not needed where only some of its voxels are: what lies
/// in its other halves.
std::uint64_t spared_bytes(std::uint64_t length, const Box& part, const Box& brick) {
  std::uint64_t halves_met = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t middle = brick.lo[axis] + (brick.size()[axis] + 1) / 2;
    halves_met *= part.lo[axis] < middle && part.hi[axis] > middle ? 2u : 1u;
  }
  return length - length / 8 * halves_met;
}

class BoxPlanner {
 public:
  BoxPlanner(const OpenFile& file, int level, UnknownParts unknown)
      : file_(file), level_(level), tier_(Levels::tier_of(level)), unknown_(unknown) {}

  /// A brick whose voxels inside `part` are wanted. Throws Error{corrupt}
  void add_brick(const Index3& position, const Box& part, const IsDecoded& is_decoded) {
    const std::size_t page = file_.page_of(tier_, position);
    if (!file_.has_page(tier_, page)) {
      if (pages_.insert(page).second) needed_.push_back(file_.page_range(tier_, page));
      is_complete_ = false;
      return;
    }
    const BrickEntry entry = file_.entry_at(tier_, position);
    if (entry.is_uniform() || (is_decoded && is_decoded(entry, part))) return;
    const bool has_model = file_.has_codec(entry.model);
    if (!has_model && models_.insert(entry.model).second) {
      const Piece piece = file_.model_piece(entry.model);
      needed_.push_back({piece.offset, piece.length});
    }
    const std::size_t first = first_piece(entry, part, has_model);
    for (std::size_t i = first; i < entry.pieces.size(); ++i) add_piece(entry, i);
  }

  /// How many bytes it may spare to ask for lists of parts first.
  std::uint64_t spared_bytes() const { return spared_bytes_; }

  /// What the bricks need, at hand or not.
  std::vector<ByteRange> needed() const { return joined(needed_, kNoGaps); }

  ReadPlan plan(const JoinLimits& limits) const {
    ReadPlan plan;
    const std::vector<ByteRange> missing = file_.source().missing(needed_);
    plan.needed_bytes = total_bytes(missing);
    plan.ranges = joined(missing, limits);
    plan.is_complete = is_complete_;
    return plan;
  }

 private:
  void add_piece(const BrickEntry& entry, std::size_t number) {
    const BrickEntry::StoredPiece& piece = entry.pieces[number];
    if (piece.length > 0) needed_.push_back({piece.offset, piece.length});
  }

  /// The finest piece that is needed whole. Adds those parts of level 0 that decode alone.
  std::size_t first_piece(const BrickEntry& entry, const Box& part, bool has_model) {
    const int in_brick = level_ - Levels::first_level(tier_);
    if (entry.pieces.back().length == 0) return 0;
    if (in_brick > 0) return static_cast<std::size_t>(piece_of_level(in_brick));
    const Box whole = brick_box_at(file_.levels(), level_, entry.brick);
    const BrickShape shape = brick_shape(file_.levels(), tier_, entry.brick);
    // A brick of fewer levels has no parts, whatever its model.
    if (part == whole || shape.level_count < 3) return 0;
    if (!has_model) return first_of_unknown(entry, part, whole);
    const auto codec = file_.codec(entry.model);
    if (!codec->has_parts(shape)) return 0;
    const Piece piece = file_.piece_of(entry, 1);
    const ByteRange list{piece.offset, std::min(piece.length, kPartListBytes)};
    if (!file_.source().missing({&list, 1}).empty()) return first_of_unknown(entry, part, whole);
    add_parts(entry, *codec, shape, {part, whole.lo});
    return 1;
  }

  std::size_t first_of_unknown(const BrickEntry& entry, const Box& part, const Box& whole) {
    if (unknown_ == UnknownParts::brick) return 0;
    spared_bytes_ += octavo::spared_bytes(entry.pieces.front().length, part, whole);
    is_complete_ = false;
    return 1;
  }

  struct WantedBox {
    Box box;
    Index3 origin;  ///< of the brick
  };

  /// Parts by their list, which stands at the front of level 1. It is not proven here: where it is
  /// damaged, reading says so, and needs none of the parts for that.
  void add_parts(const BrickEntry& entry, const BrickCodec& codec, const BrickShape& shape,
                 const WantedBox& wanted) {
    const Piece piece = file_.piece_of(entry, 1);
    Bytes front;
    file_.read_within(piece, 0, std::min(piece.length, kPartListBytes), front);
    const BrickEntry::StoredPiece& finest = entry.pieces.front();
    for (const BrickParts::Part& part : parts_in(front, codec, shape)) {
      if (part.offset > finest.length || part.length > finest.length - part.offset) return;
      if (intersection(moved(part.box, wanted.origin), wanted.box).is_empty()) continue;
      needed_.push_back({finest.offset + part.offset, part.length});
    }
  }

  static std::vector<BrickParts::Part> parts_in(const Bytes& front, const BrickCodec& codec,
                                                const BrickShape& shape) {
    try {
      return codec.list_parts(shape, front);
    } catch (const Error&) {
      return {};
    }
  }

  const OpenFile& file_;
  int level_;
  int tier_;
  UnknownParts unknown_;
  std::uint64_t spared_bytes_ = 0;
  std::set<std::size_t> pages_;
  std::set<std::uint32_t> models_;
  std::vector<ByteRange> needed_;
  bool is_complete_ = true;
};

/// Plans of more bricks are not made: they would take more memory than what they fetch.
constexpr std::int64_t kMostPlannedBricks = 1 << 14;
/// Of plans for one box: pages, models and pieces, parts, and once more where others read as well.
constexpr int kMostPlans = 4;

/// Of a box that is read in parts, each has so many bytes at most, or one brick: enough to be worth
/// a round of requests, and few enough for some to be decoded while others come.
constexpr std::uint64_t kPartBytes = std::uint64_t{1} << 24;

/// The halves of a box, cut between bricks; across z as long as that is possible, as layers follow
/// one another in a file.
std::pair<Box, Box> halves_of(const Box& box, const Size3& side, const Size3& met) {
  int axis = 2;
  while (met[axis] == 1) --axis;
  const std::int64_t cut = (box.lo[axis] / side[axis] + met[axis] / 2) * side[axis];
  std::pair<Box, Box> halves{box, box};
  halves.first.hi[axis] = cut;
  halves.second.lo[axis] = cut;
  return halves;
}

BoxPlanner planner_of(const OpenFile& file, std::span<const Box> boxes, int level,
                      const IsDecoded& is_decoded, UnknownParts unknown = UnknownParts::list) {
  BoxPlanner planner(file, level, unknown);
  for (const Box& box : boxes) {
    visit_cells(box, brick_side_at(file.levels(), level), [&](const Index3& position) {
      const Box whole = brick_box_at(file.levels(), level, position);
      planner.add_brick(position, intersection(box, whole), is_decoded);
      return true;
    });
  }
  return planner;
}

/// As planner_of, with whole bricks where those bytes come sooner than another round of requests.
/// room  bytes that may be fetched, and that may be needed
BoxPlanner sooner_planner_of(const OpenFile& file, std::span<const Box> boxes, int level,
                             const IsDecoded& is_decoded, std::uint64_t room) {
  BoxPlanner planner = planner_of(file, boxes, level, is_decoded);
  const std::uint64_t spared = planner.spared_bytes();
  if (spared == 0 || spared > file.source().bytes_per_round()) return planner;
  BoxPlanner whole = planner_of(file, boxes, level, is_decoded, UnknownParts::brick);
  const bool has_room = total_bytes(whole.needed()) <= room &&
                        total_bytes(whole.plan({}).ranges) <= room;
  return has_room ? std::move(whole) : std::move(planner);
}

/// Bytes stay in a source as long as these live.
using Holds = std::vector<std::shared_ptr<const void>>;

/// Fetches what boxes need, and holds it. Nothing where that is more than `most_bytes`, at hand or
/// not, or more than the source keeps.
std::optional<Holds> fetch_held(const OpenFile& file, std::span<const Box> boxes, int level,
                                const IsDecoded& is_decoded, std::uint64_t most_bytes) {
  const ByteSource& source = file.source();
  const Size3 side = brick_side_at(file.levels(), level);
  std::int64_t brick_count = 0;
  for (const Box& box : boxes) brick_count += cells_met(box, side).voxel_count();
  if (brick_count > kMostPlannedBricks) return std::nullopt;
  Holds holds;
  std::uint64_t fetched = 0;
  const std::uint64_t most_fetched = std::min(source.fetched_bytes_kept(), most_bytes);
  for (int i = 0; i < kMostPlans; ++i) {
    const BoxPlanner planner =
        sooner_planner_of(file, boxes, level, is_decoded, most_fetched - fetched);
    const std::vector<ByteRange> needed = planner.needed();
    if (total_bytes(needed) > most_bytes) return std::nullopt;
    // Before the plan: what it finds at hand must not make room for what it fetches.
    holds.push_back(source.hold(needed));
    const ReadPlan plan = planner.plan({});
    fetched += total_bytes(plan.ranges);
    if (fetched > most_fetched) return std::nullopt;
    if (!plan.ranges.empty()) source.fetch(plan.ranges);
    if (plan.is_complete) break;
  }
  return holds;
}

/// Reads a box in parts. What the part before needs is held until the one after it was handed out:
/// halves that turn out too large are fetched in part, too, and may push out whatever is not held.
class PartsInTurn {
 public:
  PartsInTurn(const OpenFile& file, int level, const IsDecoded& is_decoded,
              const std::function<void(const Box& part)>& read)
      : file_(file),
        level_(level),
        is_decoded_(is_decoded),
        read_(read) {}

  void read(const Box& box) {
    const Size3 side = brick_side_at(file_.levels(), level_);
    const Size3 met = cells_met(box, side);
    const bool is_brick = met.voxel_count() == 1;
    const std::uint64_t kept = file_.source().fetched_bytes_kept();
    const std::uint64_t most_bytes = is_brick ? kept : std::min(kPartBytes, kept / 2);
    std::optional<Holds> fresh = fetch_held(file_, {&box, 1}, level_, is_decoded_, most_bytes);
    if (!fresh && !is_brick) {
      const auto [first, second] = halves_of(box, side, met);
      read(first);
      read(second);
      return;
    }
    read_(box);
    holds_ = fresh ? std::move(*fresh) : Holds{};
  }

 private:
  const OpenFile& file_;
  int level_;
  const IsDecoded& is_decoded_;
  const std::function<void(const Box& part)>& read_;
  Holds holds_;  ///< of the part that was handed out last
};

}  // namespace

bool fetch_boxes(const OpenFile& file, std::span<const Box> boxes, int level,
                 const IsDecoded& is_decoded) {
  if (file.source().fetched_bytes_kept() == 0) return true;
  constexpr auto kAny = std::numeric_limits<std::uint64_t>::max();
  return fetch_held(file, boxes, level, is_decoded, kAny).has_value();
}

void for_fetched(const OpenFile& file, const Box& box, int level, const IsDecoded& is_decoded,
                 const std::function<void(const Box& part)>& read) {
  if (file.source().fetched_bytes_kept() == 0) return read(box);
  PartsInTurn(file, level, is_decoded, read).read(box);
}

ReadPlan plan_of_boxes(const OpenFile& file, std::span<const Box> boxes, int level,
                       const JoinLimits& limits, const IsDecoded& is_decoded) {
  return planner_of(file, boxes, level, is_decoded).plan(limits);
}

}  // namespace octavo
