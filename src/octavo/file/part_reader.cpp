#include "octavo/file/part_reader.h"

#include <algorithm>
#include <array>
#include <exception>
#include <functional>

#include "octavo/file/held_planes.h"

namespace octavo {

namespace {

/// So many parts at once keep a thread busy: the steps of one do not wait for those of the other.
constexpr std::size_t kPartsAtOnce = 2;

// Of a part of level 0 among the decoded bricks.
LruCache<Bytes>::Key key_of_part(const BrickEntry& entry, std::size_t part) {
  constexpr std::uint64_t kPlaceOfPart = 256;
  const auto level = static_cast<std::uint64_t>(Levels::first_level(entry.tier));
  return {level + kPlaceOfPart * (part + 1), entry.code};
}

void run_here(std::int64_t count, const std::function<void(std::int64_t)>& task) {
  for (std::int64_t i = 0; i < count; ++i) task(i);
}

// Runs tasks to the end, and throws what the first of them threw, by number.
void run_to_end(const ForEach* run, std::size_t count,
                const std::function<void(std::size_t)>& task) {
  std::vector<std::exception_ptr> errors(count);
  const auto caught = [&](std::int64_t number) {
    const auto i = static_cast<std::size_t>(number);
    try {
      task(i);
    } catch (...) {
      errors[i] = std::current_exception();
    }
  };
  if (run != nullptr) (*run)(static_cast<std::int64_t>(count), caught);
  else run_here(static_cast<std::int64_t>(count), caught);
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace

PartReader::PartReader(const OpenFile& file, LruCache<Bytes>& decoded,
                       const ReaderOptions& options)
    : file_(file),
      decoded_(decoded),
      opened_(options.cache_bytes / kOpenedShare),
      watcher_(options.watcher) {}

/// The brick decoded down to level 1; null where its level 0 has no parts.
std::shared_ptr<const PartReader::Opened> PartReader::opened(const BrickEntry& entry) const {
  const BrickShape shape = brick_shape(file_.levels(), entry.tier, entry.brick);
  const auto codec = file_.codec(entry.model);
  if (!codec->has_parts(shape) || entry.pieces.back().length == 0) return nullptr;
  const LruCache<Opened>::Key key{static_cast<std::uint64_t>(entry.tier), entry.code};
  if (auto kept = opened_.find(key)) return kept;
  auto brick = std::make_shared<Opened>(Opened{codec, nullptr});
  const BrickBytes bytes = file_.read_segments(entry, 1);
  try {
    brick->parts = codec->open_parts(
        shape, file_.description().coded_type(), entry.range,
        std::span(bytes.segments).first(static_cast<std::size_t>(shape.level_count)));
    const BrickParts::Part& last = brick->parts->parts().back();
    if (last.offset + last.length != entry.pieces.front().length) {
      throw Error(ErrorKind::corrupt, "the parts of level 0 do not fill their segment");
    }
  } catch (const Error& error) {
    const Piece piece = file_.piece_of(entry, piece_of_level(1));
    throw Error(error.kind(), describe(piece) + ": " + error.detail(), file_.source().name(),
                piece.offset);
  }
  // Samples of 16 or 32 bits, with margins.
  constexpr std::uint64_t kMostBytesPerSample = 8;
  opened_.insert(key, brick, sizeof(Opened) + kMostBytesPerSample *
                                 static_cast<std::uint64_t>(shape.size[1].voxel_count()));
  return brick;
}

/// Reads parts of a brick. Those that follow each other take one read.
/// missing  their numbers rise
/// reads    what holds the bytes
std::vector<PartReader::Found> PartReader::read_bytes(const Request& request,
                                                      std::span<const Missing> missing,
                                                      std::vector<Bytes>& reads) const {
  const std::vector<BrickParts::Part>& parts = request.brick.parts->parts();
  const Piece piece = file_.piece_of(request.entry, 0);
  std::vector<Found> found;
  for (std::size_t first = 0; first < missing.size();) {
    std::size_t end = first + 1;
    while (end < missing.size() && missing[end].number == missing[end - 1].number + 1) ++end;
    const std::uint64_t start = parts[missing[first].number].offset;
    const BrickParts::Part& last = parts[missing[end - 1].number];
    const Bytes& read =
        reads.emplace_back(file_.read_within(piece, start, last.offset + last.length - start));
    for (; first < end; ++first) {
      const auto [number, is_new] = missing[first];
      const BrickParts::Part& part = parts[number];
      found.push_back({number, is_new, ByteSpan(read).subspan(part.offset - start, part.length)});
    }
  }
  return found;
}

/// Decodes voxels of parts; says which of them is damaged.
void PartReader::decode(const Request& request, std::span<const BrickParts::Wanted> wanted) const {
  const BrickParts& parts = *request.brick.parts;
  try {
    return parts.decode(wanted);
  } catch (const Error&) {
    // One of them: below it is found which.
  }
  for (const BrickParts::Wanted& one : wanted) {
    try {
      parts.decode(std::span(&one, 1));
    } catch (const Error& error) {
      const Piece piece = file_.piece_of(request.entry, 0);
      throw Error(error.kind(), describe(piece) + ": " + error.detail(), file_.source().name(),
                  piece.offset + parts.parts()[one.number].offset);
    }
  }
}

/// Decodes some parts into the array of the request, and keeps them where it says so.
/// parts  at most kPartsAtOnce
void PartReader::decode_found(const Request& request, std::span<const Found> parts) const {
  const VolumeDescription& volume = file_.description();
  const BoxTarget& out = request.out;
  // What nobody keeps takes no memory of its own, which the system would have to give anew.
  thread_local std::array<Bytes, kPartsAtOnce> passing;
  std::array<std::shared_ptr<Bytes>, kPartsAtOnce> kept;
  std::array<BrickParts::Wanted, kPartsAtOnce> wanted;
  std::array<std::uint8_t*, kPartsAtOnce> dense{};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Index3& at = request.at;
    const Index3 back{-at.x, -at.y, -at.z};
    const Box all = moved(request.brick.parts->parts()[parts[i].number].box, at);
    const Box shared = intersection(all, request.box);
    const Box own = moved(decoded_for(request.box, all, request.axis, parts[i].is_new), back);
    const Size3 size = own.size();
    const auto bytes = static_cast<std::size_t>(size.voxel_count()) * out.voxel_bytes;
    const bool is_kept = request.keeps && bytes <= decoded_.capacity();
    wanted[i] = {parts[i].number, parts[i].bytes, own, {}};
    if (!is_kept && !volume.coding && is_aligned(out)) {
      // Straight to where they are asked for
      wanted[i].box = moved(shared, back);
      wanted[i].out = {out.from(shared.lo, request.box.lo).bytes, out.row_stride,
                       out.plane_stride};
      continue;
    }
    if (is_kept) {
      kept[i] = std::make_shared<Bytes>(bytes);
      dense[i] = kept[i]->data();
    } else {
      if (passing[i].size() < bytes) passing[i].resize(bytes);
      dense[i] = passing[i].data();
    }
    wanted[i].out = {dense[i], size.x, size.x * size.y};
  }
  decode(request, std::span(wanted).first(parts.size()));
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (dense[i] == nullptr) continue;
    const Box& own = wanted[i].box;
    if (volume.coding) {
      const auto voxels = static_cast<std::size_t>(own.size().voxel_count());
      decode_samples(*volume.coding, dense[i], {reinterpret_cast<float*>(dense[i]), voxels});
    }
    copy_shared(dense[i], moved(own, request.at), request.box, out);
    if (!kept[i]) continue;
    decoded_.insert(key_of_part(request.entry, parts[i].number), kept[i],
                    kept[i]->size() + sizeof(Bytes));
  }
}

bool PartReader::read(const BrickEntry& entry, const Box& box, const BrickReading& how,
                      const BoxTarget& out) const {
  const int level = Levels::first_level(entry.tier);
  if (decoded_.find({static_cast<std::uint64_t>(level), entry.code})) return false;
  const auto brick = opened(entry);
  if (!brick) return false;
  // Kept ones, and those that are missing
  const Index3 at = brick_box_at(file_.levels(), level, entry.brick).lo;
  const int axis = brick->codec->axis_order()[2];
  const std::vector<BrickParts::Part>& parts = brick->parts->parts();
  std::vector<Missing> missing;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Box part = moved(parts[i].box, at);
    const Box shared = intersection(part, box);
    if (shared.is_empty()) continue;
    const auto kept = decoded_.find(key_of_part(entry, i));
    const Box held = kept ? held_of(part, axis, kept->size(), out.voxel_bytes) : Box{};
    if (held.contains(shared)) copy_shared(kept->data(), held, shared, out.from(shared.lo, box.lo));
    else missing.push_back({i, kept == nullptr});
  }
  const Request request{entry, *brick, axis, at, box, out, how.keeps};
  std::vector<Bytes> reads;
  const std::vector<Found> found = read_bytes(request, missing, reads);
  // Threads share single parts.
  const std::size_t at_once = how.run == nullptr ? kPartsAtOnce : 1;
  run_to_end(how.run, (found.size() + at_once - 1) / at_once, [&](std::size_t i) {
    if (watcher_ != nullptr && watcher_->is_cancelled()) {
      throw Error(ErrorKind::cancelled, "stopped");
    }
    const std::size_t first = i * at_once;
    const std::size_t count = std::min(at_once, found.size() - first);
    decode_found(request, std::span(found).subspan(first, count));
  });
  return true;
}

bool PartReader::has_decoded(const BrickEntry& entry, const Box& box) const {
  const auto brick = opened_.find({static_cast<std::uint64_t>(entry.tier), entry.code});
  if (!brick) return false;
  const int level = Levels::first_level(entry.tier);
  const Index3 at = brick_box_at(file_.levels(), level, entry.brick).lo;
  const std::vector<BrickParts::Part>& parts = brick->parts->parts();
  const int axis = brick->codec->axis_order()[2];
  const auto voxel_bytes = static_cast<std::size_t>(bytes_per_voxel(file_.description().type));
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Box part = moved(parts[i].box, at);
    const Box shared = intersection(part, box);
    if (shared.is_empty()) continue;
    const auto kept = decoded_.find(key_of_part(entry, i));
    if (!kept || !held_of(part, axis, kept->size(), voxel_bytes).contains(shared)) return false;
  }
  return true;
}

}  // namespace octavo
