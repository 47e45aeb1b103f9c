#include <algorithm>
#include <cstring>
#include <optional>

#include "octavo/codec/label/label_codec.h"
#include "octavo/codec/label/label_octant.h"
#include "octavo/codec/label/label_pyramid.h"
#include "octavo/codec/label/label_stored.h"
#include "octavo/codec/label/label_walk.h"
#include "octavo/codec/label/label_word_bricks.h"
#include "octavo/codec/stored_brick.h"

namespace octavo {

namespace {

template <class T>
void fill(const Size3& size, std::int64_t value, void* out) {
  std::fill_n(static_cast<T*>(out), size.voxel_count(), static_cast<T>(value));
}

/// What four cells in a row are, where they are alike: looked up in the row or, where that lacks
/// the cells below uniform parents, in theirs.
std::optional<LabelCell> cell_of_four(bool is_sparse, const LabelCell* row,
                                      const LabelCell* parents) {
  if (is_sparse) {
    const bool is_one = state_of(parents[0]) == kUniform && parents[0] == parents[1];
    return is_one ? std::optional(parents[0]) : std::nullopt;
  }
  std::uint64_t four;
  std::memcpy(&four, row, sizeof four);
  return four == row[0] * 0x0001000100010001u ? std::optional(row[0]) : std::nullopt;
}

/// Rows of labels from rows of cells; four alike cells in a row are usual.
template <class T>
void write_labels(const LabelWork& work, void* out) {
  const LabelGrid& grid = work.grid;
  std::vector<T> value(work.labels.size());
  std::transform(work.labels.begin(), work.labels.end(), value.begin(),
                 [](std::int64_t label) { return static_cast<T>(label); });
  const Size3& size = grid.size();
  T* to = static_cast<T*>(out);
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y, to += size.x) {
      const LabelCell* const row = grid.at({0, y, z});
      const LabelCell* const parents = work.parents.at({0, y >> 1, z >> 1});
      std::int64_t x = 0;
      for (; x + 4 <= size.x; x += 4) {
        if (const auto cell = cell_of_four(work.is_sparse, row + x, parents + (x >> 1))) {
          std::fill_n(to + x, 4, value[slot_of(*cell)]);
        } else {
          for (std::int64_t i = x; i < x + 4; ++i) to[i] = value[slot_of(work.cell({i, y, z}))];
        }
      }
      for (; x < size.x; ++x) to[x] = value[slot_of(work.cell({x, y, z}))];
    }
  }
}

/// The labels of a level of a stored brick; those of the level above the last are its parent.
template <class T>
void decode_stored(const BrickShape& shape, const ValueRange& range, ByteSpan segment, int level,
                   T* out) {
  const Size3& size = shape.size[0];
  const auto labels = decode_stored_labels(segment, range, size.voxel_count());
  if (level == 0) {
    std::transform(labels.begin(), labels.end(), out,
                   [](std::int64_t label) { return static_cast<T>(label); });
    return;
  }
  std::vector<T> voxels(labels.size());
  std::transform(labels.begin(), labels.end(), voxels.begin(),
                 [](std::int64_t label) { return static_cast<T>(label); });
  const LabelPyramid pyramid = build_label_pyramid(
      shape, {voxels.data(), voxel_type_of<T>(), size, size.x, size.x * size.y});
  const LabelPyramid::Level& wanted = pyramid.levels[static_cast<std::size_t>(level)];
  std::transform(wanted.rank.begin(), wanted.rank.end(), out, [&](std::uint32_t rank) {
    return static_cast<T>(pyramid.labels[rank]);
  });
}

void check(const BrickShape& shape, VoxelType type, const ValueRange& range,
           std::span<const ByteSpan> segments, int level) {
  check_label_shape(shape);
  if (level < 0 || level >= shape.level_count ||
      segments.size() != static_cast<std::size_t>(shape.level_count)) {
    throw Error(ErrorKind::invalid_argument, "a brick has one segment per level, found " +
                                                 std::to_string(segments.size()));
  }
  const ValueRange all = value_range(type);
  if (range.min > range.max || range.min < all.min || range.max > all.max) {
    throw Error(ErrorKind::corrupt, "brick: its range of labels does not fit its voxel type");
  }
}

}  // namespace

void LabelCodec::decode(const BrickShape& shape, VoxelType type, const ValueRange& range,
                        std::span<const ByteSpan> segments, int level, void* out) const {
  if (type != type_) {
    throw Error(ErrorKind::invalid_argument, "a label model was made for another voxel type");
  }
  check(shape, type, range, segments, level);
  if (range.min == range.max) {
    with_voxel_type(type, [&](auto t) {
      fill<typename decltype(t)::type>(shape.size[static_cast<std::size_t>(level)], range.min, out);
    });
    return;
  }
  if (is_stored(shape, segments)) {
    with_voxel_type(type, [&](auto t) {
      using T = typename decltype(t)::type;
      decode_stored<T>(shape, range, segments[0], level, static_cast<T*>(out));
    });
    return;
  }
  LabelWork& work = thread_label_work();
  label_walk_functions().decode(model_, shape, range, segments, level, work);
  with_voxel_type(type, [&](auto t) {
    write_labels<typename decltype(t)::type>(work, out);
  });
}

std::int64_t LabelCodec::decode_parent(const BrickShape& shape, VoxelType type,
                                       const ValueRange& range,
                                       std::span<const ByteSpan> segments) const {
  const int coarsest = shape.level_count - 1;
  check(shape, type, range, segments, coarsest);
  if (range.min == range.max) return range.min;
  if (is_stored(shape, segments)) {
    return with_voxel_type(type, [&](auto t) {
      typename decltype(t)::type parent;
      decode_stored(shape, range, segments[0], shape.level_count, &parent);
      return static_cast<std::int64_t>(parent);
    });
  }
  // A traversal starts from the parent: its label is the first that it meets
  LabelWork& work = thread_label_work();
  label_walk_functions().decode(model_, shape, range, segments, coarsest, work);
  return work.labels.front();
}

void LabelCodec::decode_words(const BrickShape& shape, const ValueRange& range,
                              std::span<const ByteSpan> segments, LabelWords& words) const {
  check(shape, type_, range, segments, 0);
  const Size3& size = shape.size[0];
  if (range.min == range.max) {
    fill_words(size, range.min, words);
  } else if (is_stored(shape, segments)) {
    words_of_voxels(size, decode_stored_labels(segments[0], range, size.voxel_count()), words);
  } else {
    LabelWork& work = thread_label_work();
    label_walk_functions().decode(model_, shape, range, segments, 0, work);
    words_of_cells(shape, work, words);
  }
}

std::unique_ptr<BrickCodec> parse_label_model(VoxelType type, ByteSpan bytes) {
  if (!is_integer(type)) throw Error(ErrorKind::corrupt, "a label model for float voxels");
  return std::make_unique<LabelCodec>(type, parse_label_weights(type, bytes));
}

}  // namespace octavo
