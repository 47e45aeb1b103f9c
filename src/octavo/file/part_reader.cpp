#include "octavo/file/part_reader.h"

#include <algorithm>
#include <array>
#include <exception>
#include <functional>
#include <utility>

#include "octavo/file/held_planes.h"

namespace octavo {

namespace {

/// So many parts at once keep a thread busy: the steps of one do not wait for those of the other.
constexpr std::size_t kPartsAtOnce = 8;

// Of a part of level 0 among the decoded bricks.
LruCache<UnsetBytes>::Key key_of_part(const BrickEntry& entry, std::size_t part) {
  constexpr std::uint64_t kPlaceOfPart = 256;
  const auto level = static_cast<std::uint64_t>(Levels::first_level(entry.tier));
  return {level + kPlaceOfPart * (part + 1), entry.code};
}

/// Planes of a part of which a request asks for few along an axis on which parts are not decoded
/// plane by plane; empty where it asks for others.
/// axis  on which they are
Box slab_of(const Box& request, const Box& part, int axis) {
  if (request.size()[axis] <= kFewPlanes) return {};
  for (int across = 0; across < 3; ++across) {
    if (request.size()[across] > kFewPlanes) continue;
    Box slab = part;
    slab.lo[across] = intersection(request, part).lo[across];
    slab.hi[across] = intersection(request, part).hi[across];
    return slab == part ? Box{} : slab;
  }
  return {};
}

// Of a slab of a part among the decoded bricks.
LruCache<UnsetBytes>::Key key_of_slab(const BrickEntry& entry, std::size_t number, const Box& slab,
                                      const Box& part) {
  std::uint64_t place = 1;
  for (int axis = 0; axis < 3; ++axis) {
    constexpr std::uint64_t kPlaces = 64;
    place = place * kPlaces + static_cast<std::uint64_t>(slab.lo[axis] - part.lo[axis]);
    place = place * kPlaces + static_cast<std::uint64_t>(slab.size()[axis] - 1);
  }
  LruCache<UnsetBytes>::Key key = key_of_part(entry, number);
  key.first |= place << 16;
  return key;
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

PartReader::PartReader(const OpenFile& file, LruCache<UnsetBytes>& decoded,
                       const ReaderOptions& options)
    : file_(file),
      decoded_(decoded),
      opened_(options.cache_bytes / kOpenedShare),
      watcher_(options.watcher) {}

/// Bricks decoded down to level 1; null where level 0 has no parts.
std::vector<std::shared_ptr<const PartReader::Opened>> PartReader::opened(
    std::span<const BrickEntry> entries) const {
  std::vector<std::shared_ptr<const Opened>> bricks(entries.size());
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const BrickEntry& entry = entries[i];
    if (!has_parts(entry)) continue;
    bricks[i] = opened_.find({static_cast<std::uint64_t>(entry.tier), entry.code});
    if (!bricks[i]) missing.push_back(i);
  }
  std::vector<BrickBytes> bytes;
  std::vector<CodedBrick> coded;
  bytes.reserve(missing.size());
  for (std::size_t first = 0; first < missing.size();) {
    // Those of one model, which follow each other
    const std::uint32_t model = entries[missing[first]].model;
    bytes.clear();
    coded.clear();
    for (std::size_t k = first; k < missing.size(); ++k) {
      const BrickEntry& entry = entries[missing[k]];
      if (entry.model != model) break;
      const BrickShape shape = brick_shape(file_.levels(), entry.tier, entry.brick);
      bytes.push_back(file_.read_segments(entry, 1));
      coded.push_back({shape, entry.range,
                       std::span(bytes.back().segments)
                           .first(static_cast<std::size_t>(shape.level_count))});
    }
    const auto codec = file_.codec(model);
    auto parts = open_together(*codec, entries[missing[first]], coded);
    for (std::size_t k = 0; k < parts.size(); ++k, ++first) {
      const std::size_t i = missing[first];
      bricks[i] = kept(entries[i], codec, std::move(parts[k]), coded[k].shape);
    }
  }
  return bricks;
}

bool PartReader::has_parts(const BrickEntry& entry) const {
  return entry.pieces.back().length > 0 &&
         file_.codec(entry.model)->has_parts(
             brick_shape(file_.levels(), entry.tier, entry.brick));
}

/// first  what is wrong with one brick alone is said of it
std::vector<std::unique_ptr<BrickParts>> PartReader::open_together(
    const BrickCodec& codec, const BrickEntry& first, std::span<const CodedBrick> bricks) const {
  try {
    return codec.open_together(file_.description().coded_type(), bricks);
  } catch (const Error& error) {
    throw error_in(first, 1, 0, error);
  }
}

/// An error in the bytes of a brick that are decoded for a level, `offset` behind their first.
Error PartReader::error_in(const BrickEntry& entry, int level, std::uint64_t offset,
                           const Error& error) const {
  const Piece piece = file_.piece_of(entry, piece_of_level(level));
  return Error(error.kind(), describe(piece) + ": " + error.detail(), file_.source().name(),
               piece.offset + offset);
}

/// An opened brick, kept for later requests.
std::shared_ptr<const PartReader::Opened> PartReader::kept(
    const BrickEntry& entry, std::shared_ptr<const BrickCodec> codec,
    std::unique_ptr<const BrickParts> parts, const BrickShape& shape) const {
  if (!parts) throw error_in(entry, 1, 0, Error(ErrorKind::corrupt, "no coarsest samples"));
  const BrickParts::Part& last = parts->parts().back();
  if (last.offset + last.length != entry.pieces.front().length) {
    throw error_in(entry, 1, 0,
                   Error(ErrorKind::corrupt, "the parts of level 0 do not fill their segment"));
  }
  const auto brick = std::make_shared<const Opened>(Opened{std::move(codec), std::move(parts)});
  // Samples of 16 or 32 bits, with margins.
  constexpr std::uint64_t kMostBytesPerSample = 8;
  opened_.insert({static_cast<std::uint64_t>(entry.tier), entry.code}, brick,
                 sizeof(Opened) + kMostBytesPerSample *
                                      static_cast<std::uint64_t>(shape.size[1].voxel_count()));
  return brick;
}

/// Reads parts of a brick. Those that follow each other take one read.
/// missing  their numbers rise
/// reads    what holds the bytes
/// found    where the parts are added
void PartReader::read_bytes(const Request& request, std::span<const Missing> missing,
                            std::vector<PartBytes>& reads, std::vector<Found>& found) const {
  const std::vector<BrickParts::Part>& parts = request.brick.parts->parts();
  const Piece piece = file_.piece_of(request.entry, 0);
  for (std::size_t first = 0; first < missing.size();) {
    std::size_t end = first + 1;
    while (end < missing.size() && missing[end].number == missing[end - 1].number + 1) ++end;
    const std::uint64_t start = parts[missing[first].number].offset;
    const BrickParts::Part& last = parts[missing[end - 1].number];
    Bytes& read = *reads.emplace_back();
    file_.read_within(piece, start, last.offset + last.length - start, read);
    for (; first < end; ++first) {
      const auto [number, is_new] = missing[first];
      const BrickParts::Part& part = parts[number];
      found.push_back(
          {&request, number, is_new, ByteSpan(read).subspan(part.offset - start, part.length)});
    }
  }
}

/// Decodes voxels of parts; says which of them is damaged.
void PartReader::decode(std::span<const Found> parts,
                        std::span<const BrickParts::WantedOf> wanted) const {
  try {
    return wanted.front().brick->decode_together(wanted);
  } catch (const Error&) {
    // One of them: below it is found which.
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto& [brick, own] = wanted[i];
    try {
      brick->decode(std::span(&own, 1));
    } catch (const Error& error) {
      throw error_in(parts[i].request->entry, 0, brick->parts()[own.number].offset, error);
    }
  }
}

/// Decodes some parts into the arrays of their requests, and keeps them where those say so.
/// parts  at most kPartsAtOnce
void PartReader::decode_found(std::span<const Found> parts) const {
  const VolumeDescription& volume = file_.description();
  // What nobody keeps takes no memory of its own, which the system would have to give anew.
  thread_local std::array<Bytes, kPartsAtOnce> passing;
  std::array<std::shared_ptr<UnsetBytes>, kPartsAtOnce> kept;
  std::array<BrickParts::WantedOf, kPartsAtOnce> wanted;
  std::array<std::uint8_t*, kPartsAtOnce> dense{};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Request& request = *parts[i].request;
    const BoxTarget& out = request.out;
    const Index3& at = request.at;
    const Index3 back{-at.x, -at.y, -at.z};
    const BrickParts& brick = *request.brick.parts;
    const Box all = moved(brick.parts()[parts[i].number].box, at);
    const Box shared = intersection(all, request.box);
    const Box slab = parts[i].is_new ? slab_of(request.box, all, request.axis) : Box{};
    const Box first = decoded_for(request.box, all, request.axis, parts[i].is_new);
    const Box own = moved(slab.is_empty() ? first : slab, back);
    const Size3 size = own.size();
    const auto bytes = static_cast<std::size_t>(size.voxel_count()) * out.voxel_bytes;
    const bool is_kept = request.keeps && bytes <= decoded_.capacity();
    BrickParts::Wanted& of_part = wanted[i].wanted;
    wanted[i].brick = &brick;
    of_part = {parts[i].number, parts[i].bytes, own, {}};
    if (!is_kept && !volume.coding && is_aligned(out)) {
      // Straight to where they are asked for
      of_part.box = moved(shared, back);
      of_part.out = {out.from(shared.lo, request.box.lo).bytes, out.row_stride,
                       out.plane_stride};
      continue;
    }
    if (is_kept) {
      kept[i] = std::make_shared<UnsetBytes>(bytes);
      dense[i] = reinterpret_cast<std::uint8_t*>(kept[i]->data());
    } else {
      if (passing[i].size() < bytes) passing[i].resize(bytes);
      dense[i] = passing[i].data();
    }
    of_part.out = {dense[i], size.x, size.x * size.y};
  }
  decode(parts, std::span(wanted).first(parts.size()));
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (dense[i] == nullptr) continue;
    const Request& request = *parts[i].request;
    const Box& own = wanted[i].wanted.box;
    if (volume.coding) {
      const auto voxels = static_cast<std::size_t>(own.size().voxel_count());
      decode_samples(*volume.coding, dense[i], {reinterpret_cast<float*>(dense[i]), voxels});
    }
    copy_shared(dense[i], moved(own, request.at), request.box, request.out);
    if (!kept[i]) continue;
    keep(parts[i], moved(own, request.at), kept[i]);
  }
}

/// Keeps what was decoded of a part. Beside a slab stands that something was.
void PartReader::keep(const Found& part, const Box& own,
                      const std::shared_ptr<const UnsetBytes>& bytes) const {
  const Request& request = *part.request;
  const Box all = moved(request.brick.parts->parts()[part.number].box, request.at);
  const Box slab = part.is_new ? slab_of(request.box, all, request.axis) : Box{};
  const auto insert = [&](const LruCache<UnsetBytes>::Key& key, auto&& value) {
    decoded_.insert(key, value, value->size() + sizeof(UnsetBytes));
  };
  const auto key = key_of_part(request.entry, part.number);
  if (own != slab) return insert(key, bytes);
  insert(key_of_slab(request.entry, part.number, slab, all), bytes);
  insert(key, std::make_shared<const UnsetBytes>());
}

/// What is kept of a part that holds what a request shares with it.
PartReader::Held PartReader::held(const PartOf& part, const Box& request,
                                  std::size_t voxel_bytes) const {
  const Box shared = intersection(part.box, request);
  const auto kept = decoded_.find(key_of_part(part.entry, part.number));
  if (!kept) return {nullptr, {}, true};
  const Box planes = held_of(part.box, part.axis, kept->size(), voxel_bytes);
  if (planes.contains(shared)) return {kept, planes, false};
  const Box slab = slab_of(request, part.box, part.axis);
  if (slab.is_empty()) return {};
  return {decoded_.find(key_of_slab(part.entry, part.number, slab, part.box)), slab, false};
}

bool PartReader::reads(const BrickEntry& entry) const {
  const auto level = static_cast<std::uint64_t>(Levels::first_level(entry.tier));
  return has_parts(entry) && !decoded_.find({level, entry.code});
}

void PartReader::read(std::span<const BrickEntry> entries, const Box& box,
                      const BrickReading& how, const BoxTarget& out) const {
  const auto bricks = opened(entries);
  if (entries.size() > 1) {
    try {
      return read_together(entries, bricks, box, how, out);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::cancelled) throw;
      // Which of them is damaged is found below, and nothing of those behind it is read.
    }
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const Piece finest = file_.piece_of(entries[i], 0);
    file_.asked_again({finest.offset, finest.length}, [&] {
      read_together(entries.subspan(i, 1), std::span(bricks).subspan(i, 1), box, how, out);
    });
  }
}

void PartReader::read_together(std::span<const BrickEntry> entries,
                               std::span<const std::shared_ptr<const Opened>> bricks,
                               const Box& box, const BrickReading& how,
                               const BoxTarget& out) const {
  std::vector<Request> requests;
  requests.reserve(entries.size());  // what is found points to them
  std::vector<PartBytes> reads;
  std::vector<Found> found;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const BrickEntry& entry = entries[i];
    const Box whole = brick_box_at(file_.levels(), Levels::first_level(entry.tier), entry.brick);
    const int axis = bricks[i]->codec->axis_order()[2];
    const bool is_cut = !box.contains(whole);
    requests.push_back({entry, *bricks[i], axis, whole.lo, box, out, how.keeps || is_cut});
    read_bytes(requests.back(), copy_kept(requests.back()), reads, found);
  }
  // Threads share single parts.
  const std::size_t at_once = how.run == nullptr ? kPartsAtOnce : 1;
  run_to_end(how.run, (found.size() + at_once - 1) / at_once, [&](std::size_t i) {
    if (watcher_ != nullptr && watcher_->is_cancelled()) {
      throw Error(ErrorKind::cancelled, "stopped");
    }
    const std::size_t first = i * at_once;
    const std::size_t count = std::min(at_once, found.size() - first);
    decode_found(std::span(found).subspan(first, count));
  });
}

/// Copies what is kept of the parts that a request meets; gives the other ones.
std::vector<PartReader::Missing> PartReader::copy_kept(const Request& request) const {
  const auto& [entry, brick, axis, at, box, out, keeps] = request;
  const std::vector<BrickParts::Part>& parts = brick.parts->parts();
  std::vector<Missing> missing;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Box part = moved(parts[i].box, at);
    const Box shared = intersection(part, box);
    if (shared.is_empty()) continue;
    const auto [bytes, kept, is_new] = held({entry, i, part, axis}, box, out.voxel_bytes);
    if (bytes) copy_shared(bytes->data(), kept, shared, out.from(shared.lo, box.lo));
    else missing.push_back({i, is_new});
  }
  return missing;
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
    if (intersection(part, box).is_empty()) continue;
    if (!held({entry, i, part, axis}, box, voxel_bytes).bytes) return false;
  }
  return true;
}

}  // namespace octavo
