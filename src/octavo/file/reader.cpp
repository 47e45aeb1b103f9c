#include "octavo/file/reader.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "octavo/codec/label/label_word_bricks.h"
#include "octavo/codec/label_bricks.h"
#include "octavo/core/unset_bytes.h"
#include "octavo/file/box_plan.h"
#include "octavo/file/box_target.h"
#include "octavo/file/held_planes.h"
#include "octavo/file/open_file.h"
#include "octavo/file/part_reader.h"

namespace octavo {

namespace {

// Fills `count` voxels at `out`, aligned or not, with that of one code.
void fill_voxels(const VolumeDescription& volume, std::int64_t code, std::int64_t count,
                 std::uint8_t* out) {
  with_voxel_type(volume.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    const T voxel = static_cast<T>(volume.voxel_of(code));
    for (std::int64_t i = 0; i < count; ++i, out += sizeof(T)) {
      std::memcpy(out, &voxel, sizeof(T));
    }
  });
}

void require_labels(const FileReader& reader) {
  if (reader.description().kind == VolumeKind::labels) return;
  throw Error(ErrorKind::invalid_argument, "holds grey values, not labels",
              reader.source().name());
}

class FileReaderImpl final : public FileReader {
 public:
  FileReaderImpl(std::shared_ptr<const ByteSource> source, const ReaderOptions& options)
      : file_(std::move(source), options),
        cache_(options.cache_bytes - options.cache_bytes / PartReader::kOpenedShare),
        parts_(file_, cache_, options),
        watcher_(options.watcher) {}

  const VolumeDescription& description() const override { return file_.description(); }
  const Levels& levels() const override { return file_.levels(); }
  std::uint64_t file_bytes() const override { return file_.header().file_bytes; }
  std::uint64_t build_id() const override { return file_.header().build_id; }
  Sha256Digest voxel_digest() const override { return file_.trailer().voxel_digest; }
  const ByteSource& source() const override { return file_.source(); }
  ValueRange range() const override { return file_.root().range(); }
  double max_error() const override {
    return detail_level() > 0 ? achieved_error() : file_.header().max_error;
  }
  int detail_level() const override { return file_.header().detail_level; }
  AxisOrder axis_order() const override { return file_.codec(0)->axis_order(); }
  double achieved_error() const override {
    return static_cast<double>(file_.root().error_steps()) * error_step(file_.header());
  }

  std::string format_version() const override {
    return std::to_string(file_.header().major) + "." + std::to_string(file_.header().minor);
  }

  std::uint64_t thumbnail_bytes() const override {
    const PartEntry* part = file_.find_part(kThumbnailTag);
    return part == nullptr ? 0 : part->bytes.length;
  }

  Bytes thumbnail() const override {
    const PartEntry* part = file_.find_part(kThumbnailTag);
    return part == nullptr ? Bytes{} : file_.read_section(part->bytes, "thumbnail");
  }

  std::vector<PartEntry> parts() const override { return file_.parts(); }
  std::vector<UnknownExtension> unknown_extensions() const override {
    return file_.header().unknown_extensions;
  }

  LevelSummary level_summary(int level) const override {
    check_level(level);
    const int tier_number = Levels::tier_of(level);
    const TierIndex& tier = file_.root().tiers[static_cast<std::size_t>(tier_number)];
    const int in_brick = level - Levels::first_level(tier_number);
    const bool is_in_finer = piece_of_level(in_brick) < in_brick;
    const std::uint64_t bytes =
        is_in_finer ? 0 : tier.piece_bytes[static_cast<std::size_t>(in_brick)];
    return {levels().brick_count(tier_number), tier.uniform_count, bytes, is_in_finer};
  }

  BrickEntry brick(int tier, const Index3& position) const override {
    return file_.entry_at(tier, position);
  }

  Bytes read_piece(const BrickEntry& entry, int piece) const override;
  void read_brick(const BrickEntry& entry, int in_brick_level, void* out) const override;
  void read_words(const BrickEntry& entry, LabelWords& words) const override;

  void read(const Box& box, int level, void* out) const override {
    check_box(box, level);
    const Size3 size = box.size();
    read_strided(box, level, out, size.x, size.x * size.y);
  }

  void read_strided(const Box& box, int level, void* out, std::int64_t row_stride,
                    std::int64_t plane_stride) const override {
    read_bricks(box, level, {out, row_stride, plane_stride}, nullptr);
  }

  void read_in_tasks(const Box& box, int level, const VoxelTarget& out,
                     const ForEach& run) const override {
    read_bricks(box, level, out, &run);
  }

  ReadPlan ranges_of(const Box& box, int level, const JoinLimits& limits) const override {
    check_box(box, level);
    return plan_of_boxes(file_, {&box, 1}, level, limits, nullptr);
  }

  bool fetch(std::span<const Box> boxes, int level) const override {
    for (const Box& box : boxes) check_box(box, level);
    return fetch_boxes(file_, boxes, level, decoded_at(level));
  }

  void for_fetched(const Box& box, int level,
                   const std::function<void(const Box& part)>& read) const override {
    check_box(box, level);
    octavo::for_fetched(file_, box, level, decoded_at(level), read);
  }

 private:
  void stop_if_cancelled() const {
    if (watcher_ != nullptr && watcher_->is_cancelled()) {
      throw Error(ErrorKind::cancelled, "stopped");
    }
  }

  IsDecoded decoded_at(int level) const {
    return [this, level](const BrickEntry& entry, const Box& part) {
      return has_decoded(entry, level, part);
    };
  }

  /// Whether those voxels of a brick are kept decoded.
  bool has_decoded(const BrickEntry& entry, int level, const Box& part) const;
  void check_level(int level) const;
  void check_box(const Box& box, int level) const;
  void check_brick_level(const BrickEntry& entry, int in_brick_level) const;
  /// Calls decode(codec, shape, segments) for a brick that is not uniform, with the segments that
  /// one of its levels needs.
  template <class Decode>
  void decode_brick(const BrickEntry& entry, int in_brick_level, Decode decode) const;
  int plane_axis(const BrickEntry& entry) const {
    return file_.codec(entry.model)->axis_order()[2];
  }
  void decode_shared(const BrickEntry& entry, int level, const Box& box, bool keeps,
                     const BoxTarget& out) const;
  void read_shared(const BrickEntry& entry, int level, const Box& box, bool keeps,
                   const BoxTarget& out) const;
  bool is_in_parts(const BrickEntry& entry, int level, const Box& box, const ForEach* run) const;
  void read_bricks(const Box& box, int level, const VoxelTarget& out, const ForEach* run) const;

  OpenFile file_;
  mutable LruCache<UnsetBytes> cache_;
  PartReader parts_;
  const Progress* watcher_;
};

void FileReaderImpl::check_level(int level) const {
  if (level >= 0 && level < levels().count()) return;
  throw Error(ErrorKind::invalid_argument,
              "level " + std::to_string(level) + "; the file has levels 0 to " +
                  std::to_string(levels().count() - 1),
              source().name());
}

void FileReaderImpl::check_box(const Box& box, int level) const {
  check_level(level);
  const Size3& all = levels().size(level);
  if (box.is_empty() || !box_of(all).contains(box)) {
    throw Error(ErrorKind::invalid_argument,
                "the box is empty or not inside level " + std::to_string(level) + " of " +
                    std::to_string(all.x) + " x " + std::to_string(all.y) + " x " +
                    std::to_string(all.z),
                source().name());
  }
}

void FileReaderImpl::check_brick_level(const BrickEntry& entry, int in_brick_level) const {
  if (in_brick_level >= 0 && in_brick_level < levels().tier_level_count(entry.tier)) return;
  throw Error(ErrorKind::invalid_argument,
              "no in-brick level " + std::to_string(in_brick_level) + " in tier " +
                  std::to_string(entry.tier),
              source().name());
}

Bytes FileReaderImpl::read_piece(const BrickEntry& entry, int number) const {
  if (number < 0 || static_cast<std::size_t>(number) >= entry.pieces.size()) {
    throw Error(ErrorKind::invalid_argument,
                "no piece " + std::to_string(number) + " in tier " + std::to_string(entry.tier),
                source().name());
  }
  const Piece piece = file_.piece_of(entry, number);
  return piece.length == 0 ? Bytes{} : file_.read_piece(piece);
}

template <class Decode>
void FileReaderImpl::decode_brick(const BrickEntry& entry, int in_brick_level,
                                  Decode decode) const {
  const BrickShape shape = brick_shape(levels(), entry.tier, entry.brick);
  const BrickBytes bytes = file_.read_segments(entry, in_brick_level);
  const auto codec = file_.codec(entry.model);
  try {
    decode(*codec, shape,
           std::span(bytes.segments).first(static_cast<std::size_t>(shape.level_count)));
  } catch (const Error& error) {
    const Piece piece = file_.piece_of(entry, piece_of_level(in_brick_level));
    throw Error(error.kind(), describe(piece) + ": " + error.detail(), source().name(),
                piece.offset);
  }
}

void FileReaderImpl::read_brick(const BrickEntry& entry, int in_brick_level, void* out) const {
  stop_if_cancelled();
  check_brick_level(entry, in_brick_level);
  const BrickShape whole = brick_shape(levels(), entry.tier, entry.brick);
  const std::int64_t count = whole.size[static_cast<std::size_t>(in_brick_level)].voxel_count();
  if (entry.is_uniform()) {
    fill_voxels(description(), entry.range.min, count, static_cast<std::uint8_t*>(out));
    return;
  }
  decode_brick(entry, in_brick_level, [&](const BrickCodec& codec, const BrickShape& shape,
                                          std::span<const ByteSpan> segments) {
    codec.decode(shape, description().codec_type(), entry.range, segments, in_brick_level, out);
  });
  if (const auto& coding = description().coding; coding && !coding->is_exact) {
    decode_samples(*coding, out, {static_cast<float*>(out), static_cast<std::size_t>(count)});
  }
}

void FileReaderImpl::read_words(const BrickEntry& entry, LabelWords& words) const {
  stop_if_cancelled();
  check_brick_level(entry, 0);
  require_labels(*this);
  if (entry.is_uniform()) {
    fill_words(brick_shape(levels(), entry.tier, entry.brick).size[0], entry.range.min, words);
    return;
  }
  decode_brick(entry, 0, [&](const BrickCodec& codec, const BrickShape& shape,
                             std::span<const ByteSpan> segments) {
    as_label_codec(codec).decode_words(shape, entry.range, segments, words);
  });
}

// Reads what `box` and a brick share that is not uniform, from the cache where it has them.
void FileReaderImpl::decode_shared(const BrickEntry& entry, int level, const Box& box, bool keeps,
                                   const BoxTarget& out) const {
  const LruCache<UnsetBytes>::Key key{static_cast<std::uint64_t>(level), entry.code};
  const Box all = brick_box_at(levels(), level, entry.brick);
  const Box part = intersection(box, all);
  const int axis = plane_axis(entry);
  const auto kept = cache_.find(key);
  const Box held = kept ? held_of(all, axis, kept->size(), out.voxel_bytes) : Box{};
  if (held.contains(part)) return copy_shared(kept->data(), held, box, out);

  // Decode all of it, or the planes that are asked for first
  const Box own = file_.codec(entry.model)->decodes_planes()
                      ? decoded_for(box, all, axis, kept == nullptr)
                      : all;
  const auto& coding = description().coding;
  const bool is_scaled = coding && !coding->is_exact;
  const auto decode = [&](const Box& wanted, const VoxelTarget& to) {
    const Box inside = moved(wanted, {-all.lo.x, -all.lo.y, -all.lo.z});
    const int in_brick = level - Levels::first_level(entry.tier);
    decode_brick(entry, in_brick, [&](const BrickCodec& codec, const BrickShape& shape,
                                      std::span<const ByteSpan> segments) {
      codec.decode_box(shape, description().codec_type(), entry.range, segments,
                       {in_brick, inside, to});
    });
  };
  const Size3 size = own.size();
  const auto count = static_cast<std::size_t>(size.voxel_count());
  const bool is_kept = keeps && count * out.voxel_bytes <= cache_.capacity();
  if (!is_kept && !is_scaled && is_aligned(out)) {
    decode(part, {out.from(part.lo, box.lo).bytes, out.row_stride, out.plane_stride});
    return;
  }
  const auto samples = std::make_shared<UnsetBytes>(count * out.voxel_bytes);
  decode(own, {samples->data(), size.x, size.x * size.y});
  if (is_scaled) {
    decode_samples(*coding, samples->data(), {reinterpret_cast<float*>(samples->data()), count});
  }
  copy_shared(samples->data(), own, box, out);
  if (is_kept) cache_.insert(key, samples, samples->size() + sizeof(UnsetBytes));
}

bool FileReaderImpl::has_decoded(const BrickEntry& entry, int level, const Box& part) const {
  if (const auto kept = cache_.find({static_cast<std::uint64_t>(level), entry.code})) {
    const Box all = brick_box_at(levels(), level, entry.brick);
    const auto voxel_bytes = static_cast<std::size_t>(bytes_per_voxel(description().type));
    return held_of(all, plane_axis(entry), kept->size(), voxel_bytes)
        .contains(intersection(part, all));
  }
  if (level != Levels::first_level(entry.tier)) return false;
  return parts_.has_decoded(entry, part);
}

// Reads what `box` and the brick share.
void FileReaderImpl::read_shared(const BrickEntry& entry, int level, const Box& box, bool keeps,
                                 const BoxTarget& out) const {
  stop_if_cancelled();
  const Box whole = brick_box_at(levels(), level, entry.brick);
  const Box part = intersection(box, whole);
  if (entry.is_uniform()) {
    for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
      for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
        fill_voxels(description(), entry.range.min, part.size().x,
                    out.row(part.lo.x - box.lo.x, y - box.lo.y, z - box.lo.z));
      }
    }
    return;
  }
  decode_shared(entry, level, box, keeps || part != whole, out);
}

// Whether what `box` and a brick share is read in parts: not where the box is the brick.
bool FileReaderImpl::is_in_parts(const BrickEntry& entry, int level, const Box& box,
                                 const ForEach* run) const {
  if (entry.is_uniform() || level != Levels::first_level(entry.tier)) return false;
  const Box whole = brick_box_at(levels(), level, entry.brick);
  return (run != nullptr || box != whole) && parts_.reads(entry);
}

void FileReaderImpl::read_bricks(const Box& box, int level, const VoxelTarget& out,
                                 const ForEach* run) const {
  check_box(box, level);
  const auto voxel_bytes = static_cast<std::size_t>(bytes_per_voxel(description().type));
  const BoxTarget target{static_cast<std::uint8_t*>(out.voxels), voxel_bytes, out.row_stride,
                      out.plane_stride};
  const bool is_large =
      static_cast<std::uint64_t>(box.size().voxel_count()) * voxel_bytes > cache_.capacity() / 4;
  for_fetched(box, level, [&](const Box& part) {
    const BoxTarget own = target.from(part.lo, box.lo);
    std::vector<BrickEntry> in_parts;  // bricks on their way, in their order
    const auto read_parts = [&] {
      stop_if_cancelled();
      parts_.read(in_parts, part, {!is_large, run}, own);
      in_parts.clear();
    };
    visit_cells(part, brick_side_at(levels(), level), [&](const Index3& position) {
      BrickEntry entry = brick(Levels::tier_of(level), position);
      if (is_in_parts(entry, level, part, run)) {
        in_parts.push_back(std::move(entry));
        if (in_parts.size() == PartReader::kBricksAtOnce) read_parts();
      } else {
        if (!entry.is_uniform() && !in_parts.empty()) read_parts();
        read_shared(entry, level, part, !is_large, own);
      }
      return true;
    });
    if (!in_parts.empty()) read_parts();
  });
}

}  // namespace

Size3 brick_side_at(const Levels& levels, int level) {
  const int tier = Levels::tier_of(level);
  Size3 side = levels.brick_side(tier);
  for (int axis = 0; axis < 3; ++axis) {
    side[axis] >>= levels.halving_count(level, axis) -
                   levels.halving_count(Levels::first_level(tier), axis);
  }
  return side;
}

Box brick_box_at(const Levels& levels, int level, const Index3& brick) {
  const Size3 side = brick_side_at(levels, level);
  const Index3 lo{brick.x * side.x, brick.y * side.y, brick.z * side.z};
  return intersection({lo, {lo.x + side.x, lo.y + side.y, lo.z + side.z}},
                      box_of(levels.size(level)));
}

void FileReader::read_in_tasks(const Box& box, int level, const VoxelTarget& out,
                               const ForEach& /*run*/) const {
  read_strided(box, level, out.voxels, out.row_stride, out.plane_stride);
}

ReadPlan FileReader::ranges_of(const Box& /*box*/, int /*level*/,
                               const JoinLimits& /*limits*/) const {
  return {};
}

bool FileReader::fetch(std::span<const Box> /*boxes*/, int /*level*/) const { return true; }

void FileReader::for_fetched(const Box& box, int /*level*/,
                             const std::function<void(const Box& part)>& read) const {
  read(box);
}

void FileReader::read_words(const BrickEntry& entry, LabelWords& words) const {
  require_labels(*this);
  const Size3 size = levels().brick_box(entry.tier, entry.brick).size();
  const auto count = static_cast<std::size_t>(size.voxel_count());
  std::vector<std::int64_t> labels(count);
  with_voxel_type(description().type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    std::vector<T> voxels(count);
    read_brick(entry, 0, voxels.data());
    std::transform(voxels.begin(), voxels.end(), labels.begin(),
                   [](T voxel) { return static_cast<std::int64_t>(voxel); });
  });
  words_of_voxels(size, labels, words);
}

std::shared_ptr<FileReader> FileReader::open(std::shared_ptr<const ByteSource> source,
                                             const ReaderOptions& options) {
  return std::make_shared<FileReaderImpl>(std::move(source), options);
}

}  // namespace octavo
