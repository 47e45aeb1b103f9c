#include "octavo/ops/mask/file_mask.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/memory_limit.h"
#include "octavo/octree/label_words.h"
#include "octavo/octree/tree_child.h"
#include "octavo/octree/word_steps.h"
#include "octavo/ops/mask/mask_pieces.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

constexpr std::int64_t kCellsAtOnce = 512;

constexpr const char* kAdvice = "raise the limit, or take a coarser level";

enum class Overlap { none, all, some };

// How many of the values lowest .. highest are in the windows.
Overlap overlap_of(double lowest, double highest, std::span<const ValueWindow> windows) {
  Overlap overlap = Overlap::none;
  for (const ValueWindow& window : windows) {
    if (window.contains(lowest) && window.contains(highest)) return Overlap::all;
    if (window.lowest <= highest && window.highest >= lowest) overlap = Overlap::some;
  }
  return overlap;
}

// A brick of level 0, and how much of it is in the windows as far as its range says.
struct RangedBrick {
  BrickEntry entry;
  Overlap overlap = Overlap::none;
};

// What a thread works with; the words are those of a cell.
struct Workspace {
  std::array<std::uint64_t, LabelWords::kCount> words;
  std::vector<RangedBrick> bricks;
  std::vector<std::byte> voxels;
  LabelWords labels;
};

// Takes the bricks of a file, or boxes of a coarser level, into a mask: cells of 64^3 voxels, a
// layer at a time, each on a thread of its own.
class FileMask {
 public:
  FileMask(const FileReader& reader, int level, std::span<const ValueWindow> windows,
           Progress& progress, std::uint64_t max_bytes, const WorkPart& part)
      : reader_(reader),
        level_(level),
        windows_(windows),
        progress_(progress),
        max_bytes_(max_bytes),
        size_(reader.levels().size(level)),
        planes_(planes_of_part(size_.z, part)) {}

  MaskTree make() {
    const std::int64_t columns = (size_.x + kCellSide - 1) / kCellSide;
    const std::int64_t rows = (size_.y + kCellSide - 1) / kCellSide;
    // Of small layers several at a time, so that threads wait for each other less often.
    const std::int64_t layers = std::max(kCellsAtOnce / (columns * rows), std::int64_t{1});
    std::uint64_t bytes = 0;
    for (std::int64_t z = planes_.first; z < planes_.end; z += layers * kCellSide) {
      const std::int64_t end = std::min(z + layers * kCellSide, planes_.end);
      const std::int64_t count = columns * rows * ((end - z + kCellSide - 1) / kCellSide);
      std::vector<MaskPart> cells(static_cast<std::size_t>(count));
      parallel_for(std::int64_t{0}, count, [&](std::int64_t i) {
        if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
        cells[static_cast<std::size_t>(i)] =
            cell({i % columns * kCellSide, i / columns % rows * kCellSide,
                  z + i / (columns * rows) * kCellSide});
      });
      for (MaskPart& part : cells) {
        if (part.pieces.empty()) continue;
        bytes += memory_bytes(part);
        parts_.push_back(std::move(part));
      }
      // Twice over: the tree is a copy of its parts.
      require_memory_within(2 * bytes + spaces_.size() * sizeof(Workspace), max_bytes_,
                            "the mask", kAdvice);
      progress_.advance(end - z);
    }
    std::sort(parts_.begin(), parts_.end(), [](const MaskPart& a, const MaskPart& b) {
      return a.pieces.front().code < b.pieces.front().code;
    });
    return assemble(size_, kCellRank, parts_);
  }

 private:
  // The cell at `corner`; no piece where nothing of it is in the windows.
  MaskPart cell(const Index3& corner) {
    const Box box = intersection(child_box(corner, 0, kCellSide), box_of(size_));
    const std::uint64_t code = interleave(corner) >> 18;
    Workspace& space = spaces_.local();
    if (level_ != 0) {
      space.words.fill(0);
      add(box, box.lo, space, [&](std::byte* voxels) { reader_.read(box, level_, voxels); });
      return folded(space, code);
    }

    find_bricks(box, space);
    const auto all_are = [&](Overlap overlap) {
      return std::ranges::all_of(space.bricks, [&](const RangedBrick& brick) {
        return brick.overlap == overlap;
      });
    };
    if (all_are(Overlap::none)) return {};
    if (all_are(Overlap::all) && box.size() == Size3{kCellSide, kCellSide, kCellSide}) {
      MaskPart part;
      part.below = arrays_below(kCellRank);
      part.pieces.push_back({code, {kFullWord, 0, 0}});
      return part;
    }
    space.words.fill(0);
    for (const RangedBrick& brick : space.bricks) add_brick(brick, box, space);
    return folded(space, code);
  }

  static MaskPart folded(const Workspace& space, std::uint64_t code) {
    MaskPart part = fold_cube(space.words.data(), code);
    if (part.pieces.front().cube.is_empty()) part.pieces.clear();
    return part;
  }

  void find_bricks(const Box& box, Workspace& space) const {
    const VolumeDescription& description = reader_.description();
    space.bricks.clear();
    visit_cells(box, reader_.levels().brick_side(0), [&](const Index3& brick) {
      RangedBrick& found = space.bricks.emplace_back();
      found.entry = reader_.brick(0, brick);
      const auto [lowest, highest] = std::minmax({description.voxel_of(found.entry.range.min),
                                                  description.voxel_of(found.entry.range.max)});
      found.overlap = overlap_of(lowest, highest, windows_);
      // The range is that of the finite voxels.
      const bool may_hold_others = description.codec_type() == VoxelType::float32;
      if (found.overlap == Overlap::all && may_hold_others && !found.entry.is_uniform()) {
        found.overlap = Overlap::some;
      }
      return true;
    });
  }

  void add_brick(const RangedBrick& brick, const Box& cell, Workspace& space) const {
    if (brick.overlap == Overlap::none) return;
    const Box box = reader_.levels().brick_box(0, brick.entry.brick);
    if (brick.overlap == Overlap::all) {
      fill(box, cell.lo, space);
    } else if (reader_.description().kind == VolumeKind::labels) {
      reader_.read_words(brick.entry, space.labels);
      add_labels(box.lo, cell.lo, space);
    } else {
      add(box, cell.lo, space,
          [&](std::byte* voxels) { reader_.read_brick(brick.entry, 0, voxels); });
    }
  }

  // Where the word at a voxel stands in the cell that starts at `corner`.
  static std::uint64_t place_in(const Index3& corner, const Index3& voxel) {
    return interleave(
        {(voxel.x - corner.x) / 4, (voxel.y - corner.y) / 4, (voxel.z - corner.z) / 4});
  }

  static void fill(const Box& box, const Index3& corner, Workspace& space) {
    for (std::int64_t z = box.lo.z; z < box.hi.z; z += 4) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; y += 4) {
        for (std::int64_t x = box.lo.x; x < box.hi.x; x += 4) {
          space.words[place_in(corner, {x, y, z})] |=
              bits_within({box.hi.x - x, box.hi.y - y, box.hi.z - z});
        }
      }
    }
  }

  // Adds the words of a brick of labels at `lo`.
  void add_labels(const Index3& lo, const Index3& corner, Workspace& space) const {
    const LabelWords& labels = space.labels;
    std::vector<std::uint64_t> wanted;  // all bits of the labels in the windows
    for (const std::int64_t label : labels.labels) {
      const auto value = static_cast<double>(label);
      const bool is_in = overlap_of(value, value, windows_) == Overlap::all;
      wanted.push_back(is_in ? kFullWord : 0);
    }
    const std::uint64_t* const wanted_bits = wanted.data();
    for (std::size_t word = 0; word < LabelWords::kCount; ++word) {
      std::uint64_t bits = 0;
      for (const LabelWordPart& part : labels.parts_of(word)) {
        bits |= part.bits & wanted_bits[part.label];
      }
      if (bits == 0) continue;
      if (lo == corner) {
        space.words[word] = bits;
        continue;
      }
      const Index3 at = deinterleave(word);
      space.words[place_in(corner, {lo.x + 4 * at.x, lo.y + 4 * at.y, lo.z + 4 * at.z})] = bits;
    }
  }

  // Adds the voxels of a box, which `read` gives.
  template <class Read>
  void add(const Box& box, const Index3& corner, Workspace& space, Read read) const {
    const VoxelType type = reader_.description().type;
    const Size3 size = box.size();
    space.voxels.resize(static_cast<std::size_t>(size.voxel_count() * bytes_per_voxel(type)));
    read(space.voxels.data());
    const BrickView block{space.voxels.data(), type, size, size.x, size.x * size.y};
    const Index3 at{box.lo.x - corner.x, box.lo.y - corner.y, box.lo.z - corner.z};
    for (const ValueWindow& window : windows_) {
      add_to_cube(at, block, window, space.words.data());
    }
  }

  const FileReader& reader_;
  int level_;
  std::span<const ValueWindow> windows_;
  Progress& progress_;
  std::uint64_t max_bytes_;
  Size3 size_;
  PlanesOfPart planes_;
  std::vector<MaskPart> parts_;  // a cell each
  PerThread<Workspace> spaces_;
};

}  // namespace

PlanesOfPart planes_of_part(std::int64_t plane_count, const WorkPart& part) {
  const std::int64_t cells = (plane_count + kCellSide - 1) / kCellSide;
  return {std::min(plane_count, part.begin_of(cells) * kCellSide),
          std::min(plane_count, part.end_of(cells) * kCellSide)};
}

MaskTree mask_of_file(const FileReader& reader, int level, std::span<const ValueWindow> windows,
                      Progress& progress, std::uint64_t max_bytes, const WorkPart& part) {
  if (level < 0 || level >= reader.levels().count()) {
    throw Error(ErrorKind::invalid_argument, "there is no level " + std::to_string(level));
  }
  require_part(part);
  return FileMask(reader, level, windows, progress, max_bytes, part).make();
}

}  // namespace octavo
