#include "octavo/dist/join_steps.h"

#include <algorithm>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <utility>

#include "octavo/builder/build_setup.h"
#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/dist/clipped_bytes.h"
#include "octavo/dist/join_proof.h"
#include "octavo/file/storage/temporary.h"

namespace octavo {

namespace {

/// Of one laying out: two of the same plan differ in nothing else.
std::uint64_t new_layout_id() {
  std::random_device device;
  return std::uint64_t{device()} << 32 | device();
}

/// Names the file that was asked for, where a failure names one that grows for it.
template <class F>
auto about(const std::string& path, F action) -> decltype(action()) {
  try {
    return action();
  } catch (const Error& error) {
    const bool is_growing = error.path().starts_with(joined_name(path));
    throw is_growing ? retold(error, error.kind(), error.detail(), path) : error;
  }
}

void prove_all(const std::vector<std::shared_ptr<PartFile>>& parts, Progress& progress) {
  std::uint64_t bytes = 0;
  for (const auto& part : parts) bytes += part->stream_bytes();
  const WatchedParts watched(parts, progress);
  const ProgressScope scope(progress, "check parts", static_cast<std::int64_t>(bytes), "bytes");
  for (const auto& part : parts) part->prove();
}

/// What a part that was cut off while it was copied takes already; nothing where that is not known.
std::optional<std::uint64_t> begun_bytes(const JoinLayout& layout, Storage& storage,
                                         const std::string& path) {
  const std::optional<std::uint64_t> stored = storage.stored_bytes(joined_name(path));
  if (!stored) return std::nullopt;
  std::uint64_t whole = 0;
  for (const Section& own : own_bytes_of(layout)) whole += own.length;
  const CopiedMarks marks(layout, storage, path);
  for (const CopiedRun& run : layout.runs) {
    if (marks.hold(run.part)) whole += run.length;
  }
  return *stored - std::min(*stored, whole);
}

/// Where a part goes as soon as it is copied, the largest of them needs room; where it stands on
/// another disk, that makes no room.
/// begun  bytes of them that take room already
void require_room(Storage& storage, const std::string& path,
                  const std::vector<std::shared_ptr<PartFile>>& parts, std::uint64_t begun) {
  const std::optional<DiskSpace> here = storage.disk_space(folder_of(path));
  if (!here) return;
  std::uint64_t largest = 0;
  std::uint64_t from_elsewhere = 0;
  for (const auto& part : parts) {
    const std::optional<DiskSpace> there = storage.disk_space(folder_of(part->path()));
    const bool makes_room = there && there->disk == here->disk;
    if (makes_room) largest = std::max(largest, part->stream_bytes());
    else from_elsewhere += part->stream_bytes();
  }
  const std::uint64_t all = largest + from_elsewhere;
  const std::uint64_t needed = all - std::min(all, begun);
  if (here->free_bytes >= needed) return;
  throw no_room_for(path, needed, here->free_bytes, "; no part is removed");
}

/// "part 3, part 4" of a list that is cut; by their groups where the plan has no such parts.
std::string parts_text(const BuildPlan& plan, const std::vector<PartPlace>& places) {
  constexpr std::size_t kNamed = 20;
  std::string text;
  for (std::size_t i = 0; i < std::min(places.size(), kNamed); ++i) {
    const auto number = part_at(plan, places[i]);
    text += text.empty() ? "" : ", ";
    text += number ? "part " + std::to_string(*number) : place_text(places[i]);
  }
  return places.size() > kNamed ? text + ", ..." : text;
}

/// A failure about parts that have to be made.
Error about_parts(const BuildPlan& plan, const std::vector<PartPlace>& places, const Error& error) {
  const auto number = part_at(plan, places.front());
  return number ? error.with_field("parts.missing", std::to_string(*number)) : error;
}

/// Gives the file that was laid out its name, and marks it as sealed; where it has its name already
/// nothing is done. Returns its length
std::uint64_t name_joined(const BuildPlan& plan, Storage& storage, const std::string& path,
                          bool overwrite) {
  const std::optional<JoinLayout> layout = find_layout(plan, storage, path);
  if (!layout) return storage.open_read(path)->size();
  const std::vector<PartPlace> missing = uncopied_parts(*layout, storage, path);
  if (!missing.empty()) {
    throw about_parts(plan, missing,
                      Error(ErrorKind::io, "not copied: " + parts_text(plan, missing), path));
  }
  const std::string growing = joined_name(path);
  try {
    // Another join of these parts may have made the file meanwhile: one takes the other's place.
    const bool replaces = overwrite || is_same_file(storage, growing, path);
    check_target(storage, path, replaces);
    put_join_file(storage, sealed_name(path, plan), joined_mark(storage, growing, layout->clipped));
    if (replaces) storage.rename(growing, path);
    else storage.rename_new(growing, path);
  } catch (const Error&) {
    // Where folders have no locks another program may have sealed it meanwhile.
    if (storage.exists(growing) || !is_joined(plan, storage, path)) throw;
  }
  storage.sync_folder(folder_of(path));
  return layout->file_bytes;
}

/// Gives the draft of a layout its name. What somebody else has laid out meanwhile may hold parts
/// already: it stays, and is returned where it is of the same plan. Requires the lock of the
/// folder.
JoinLayout named_layout(const BuildPlan& plan, JoinLayout layout, Storage& storage,
                        const std::string& path) {
  const std::string draft = draft_name(path, plan);
  if (std::optional<JoinLayout> other = find_layout(plan, storage, path)) {
    remove_names(storage, {draft});
    return *other;
  }
  require_none_of_others(plan, storage, path);
  discard_join(storage, path);
  layout.own_crc = crc_of_own_bytes(layout, *storage.open_read(draft));
  storage.rename_new(draft, joined_name(path));
  put_join_file(storage, layout_name(path), layout_text(layout));
  return layout;
}

}  // namespace

JoinLayout lay_out_join(const BuildPlan& plan, const std::vector<std::shared_ptr<PartFile>>& parts,
                        Storage& storage, const std::string& path, bool overwrite,
                        const PartWork& work, Progress& progress) {
  check_target(storage, path, overwrite);
  remove_unfinished(storage, path);
  {
    // Nobody else's layout may come, with parts copied into it, between the look and the removal.
    const auto lock = storage.lock_folder(folder_of(path));
    if (std::optional<JoinLayout> layout = find_layout(plan, storage, path)) return *layout;
    require_none_of_others(plan, storage, path);
    discard_join(storage, path);
  }
  JoinLayout layout;
  layout.plan = plan.id;
  const std::uint64_t id = layout.id = new_layout_id();
  const auto note_run = [&](const PartFile& part, std::size_t stream, const Section& bytes) {
    if (bytes.length == 0) return;
    layout.runs.push_back({part.place(), part.stream(stream).offset, bytes.offset, bytes.length,
                           bytes.crc});
  };
  try {
    const BuildResult result = about(path, [&] {
      return lay_out_parts(plan, parts, storage, draft_name(path, plan), true, work, progress,
                           note_run);
    });
    layout.file_bytes = result.file_bytes;
    layout.clipped = result.clipped;
    const auto lock = storage.lock_folder(folder_of(path));
    return named_layout(plan, std::move(layout), storage, path);
  } catch (const Error& error) {
    // Another program may have been faster, and have removed parts that it has copied.
    if (error.kind() != ErrorKind::io) throw;
    const std::optional<JoinLayout> other = find_layout(plan, storage, path);
    if (!other || other->id == id) throw;
    return *other;
  }
}

namespace {

/// Says that a part is copied, and removes it where it is consumed; but where the file was laid out
/// anew meanwhile, the part is not in it.
void mark_copied(const BuildPlan& plan, const JoinLayout& layout, const PartFile& part,
                 Storage& storage, const std::string& path, bool consumes) {
  // Nobody lays out anew between the look and the removal.
  const auto lock = storage.lock_folder(folder_of(path));
  const bool is_laid_out = is_still_laid_out(layout, storage, path);
  if (!is_laid_out && !is_joined(plan, storage, path)) {
    throw Error(ErrorKind::io,
                "was laid out anew while a part was copied, which is not in it: copy it again",
                path);
  }
  const std::string mark = copied_name(layout, path, part.place());
  if (is_laid_out && !storage.exists(mark)) put_join_file(storage, mark, "");
  if (consumes) storage.remove(part.path());
}

}  // namespace

PartCopier::PartCopier(const BuildPlan& plan, JoinLayout layout, Storage& storage,
                       std::string path)
    : plan_(plan), layout_(std::move(layout)), storage_(storage), path_(std::move(path)) {
  for (const CopiedRun& run : layout_.runs) runs_[begin_of(run.part)].push_back(run);
}

bool PartCopier::is_copied(const PartPlace& place) const {
  return storage_.exists(copied_name(layout_, path_, place));
}

void PartCopier::copy(const std::shared_ptr<PartFile>& part, bool consumes,
                      Progress& progress) const {
  const PartPlace& place = part->place();

  // Whether what is laid out is the runs of this part, as it has them
  std::vector<std::size_t> streams;
  for (std::size_t stream = 0; stream < part->stream_count(); ++stream) {
    if (part->is_joined(stream) && part->stream(stream).length > 0) streams.push_back(stream);
  }
  const auto is_laid_out = [&](std::size_t stream, const CopiedRun& run) {
    const Section& bytes = part->stream(stream);
    return run.part == place && bytes.offset == run.part_offset && bytes.length == run.length &&
           bytes.crc == run.crc;
  };
  const auto found = runs_.find(begin_of(place));
  const std::vector<CopiedRun> none;
  const std::vector<CopiedRun>& runs = found == runs_.end() ? none : found->second;
  if (place.plan != plan_.id || !std::ranges::equal(streams, runs, is_laid_out)) {
    throw Error(ErrorKind::invalid_argument, "is not a part of the file that was laid out",
                part->path());
  }

  // Their bytes, then the mark that says that they are there. Copies that were changed since are
  // made again.
  const auto is_whole = [&] {
    return !storage_.exists(joined_name(path_)) ||
           damaged_copies(layout_, {place}, *storage_.open_read(joined_name(path_)), 1, progress)
               .empty();
  };
  if (is_copied(place) && (!consumes || is_whole())) {
    return mark_copied(plan_, layout_, *part, storage_, path_, consumes);
  }
  const WatchedParts watched({part}, progress);
  const ProgressScope scope(progress, "copy", static_cast<std::int64_t>(part->joined_bytes()),
                            "bytes");
  about(path_, [&] {
    const std::unique_ptr<StorageFile> file = storage_.open_shared(joined_name(path_));
    for (std::size_t i = 0; i < runs.size(); ++i) {
      std::uint64_t at = runs[i].file_offset;
      part->copy(streams[i], [&](ByteSpan bytes) {
        file->write(at, bytes);
        at += bytes.size();
      });
    }
    file->sync();
    file->close();
  });
  mark_copied(plan_, layout_, *part, storage_, path_, consumes);
}

void copy_part(const BuildPlan& plan, const std::shared_ptr<PartFile>& part, Storage& storage,
               const std::string& path, bool consumes, Progress& progress) {
  const std::optional<JoinLayout> layout = find_layout(plan, storage, path);
  if (!layout) throw Error(ErrorKind::io, "nothing is laid out for this plan", path);
  PartCopier(plan, *layout, storage, path).copy(part, consumes, progress);
}

namespace {

/// Locks the first of these parts. Of two joins that consume the same parts the second one ends
/// here, before it lays anything out: neither could get all of them.
std::unique_ptr<StorageFile> lock_of_consumer(std::span<const std::shared_ptr<PartFile>> parts,
                                              Storage& storage) {
  if (parts.empty()) return nullptr;
  const std::string& name = parts.front()->path();
  std::unique_ptr<StorageFile> lock = storage.lock_left(name);
  if (lock || !storage.is_locked(name)) return lock;
  throw Error(ErrorKind::io,
              "another join that consumes parts works on this one and those behind it", name);
}

/// Proves copies that were made before, of a file that waits for more or for its name. Those that
/// are damaged count as not copied from then on.
/// Returns  the damaged ones
/// Throws   Error{corrupt} where the file itself is
std::vector<PartPlace> drop_damaged_copies(const JoinLayout& layout, Storage& storage,
                                           const std::string& path, int threads,
                                           Progress& progress) {
  std::vector<PartPlace> copied = parts_of(layout);
  const CopiedMarks marks(layout, storage, path);
  std::erase_if(copied, [&](const PartPlace& place) { return !marks.hold(place); });
  const std::unique_ptr<StorageFile> file = storage.open_read(joined_name(path));
  if (!checksum_matches(crc_of_own_bytes(layout, *file), layout.own_crc)) {
    const std::string growing = escaped(joined_name(path));
    throw Error(ErrorKind::corrupt,
                growing + ", in which a join has begun, is damaged where no part was copied; where "
                          "all parts are still there, or can be made again, remove " +
                    growing + "*",
                path);
  }
  std::vector<PartPlace> damaged = damaged_copies(layout, copied, *file, threads, progress);
  for (const PartPlace& place : damaged) storage.remove(copied_name(layout, path, place));
  return damaged;
}

/// The same of a file that is to be sealed, unless another program has sealed it meanwhile.
void require_whole_copies(const BuildPlan& plan, Storage& storage, const std::string& path,
                          int threads, Progress& progress) {
  const std::optional<JoinLayout> layout = find_layout(plan, storage, path);
  if (!layout || !uncopied_parts(*layout, storage, path).empty()) return;
  std::vector<PartPlace> damaged;
  try {
    damaged = drop_damaged_copies(*layout, storage, path, threads, progress);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::io && !storage.exists(joined_name(path))) return;
    throw;
  }
  if (damaged.empty()) return;
  throw Error(ErrorKind::corrupt,
              "its bytes were changed since they were copied: " + parts_text(plan, damaged), path)
      .with_field("join.copy");
}

}  // namespace

std::uint64_t seal_join(const BuildPlan& plan, Storage& storage, const std::string& path,
                        bool overwrite, const PartWork& work, Progress& progress) {
  require_whole_copies(plan, storage, path, build_threads(work.threads), progress);
  // Of two that seal at once the second finds the file sealed.
  const auto lock = storage.lock_folder(folder_of(path));
  if (!find_layout(plan, storage, path) && !is_joined(plan, storage, path)) {
    throw Error(ErrorKind::io, "nothing is laid out for this plan", path);
  }
  const std::uint64_t bytes = name_joined(plan, storage, path, overwrite);
  leave_done_mark(plan, storage, path);
  return bytes;
}

namespace {

/// Before a begun join goes on, and removes more parts: what it has copied is proven, and the
/// parts of all else are there.
void require_copies_or_parts(const BuildPlan& plan, const JoinLayout& layout,
                             const std::vector<std::shared_ptr<PartFile>>& parts,
                             Storage& storage, const std::string& path, const PartWork& work,
                             Progress& progress) {
  std::set<BrickAt> there;
  for (const auto& part : parts) there.insert(begin_of(part->place()));
  const auto is_there = [&](const PartPlace& place) { return there.contains(begin_of(place)); };
  std::vector<PartPlace> damaged = drop_damaged_copies(
      layout, storage, path, build_threads(work.threads), progress);
  std::erase_if(damaged, is_there);
  if (!damaged.empty()) {
    throw about_parts(plan, damaged,
                      Error(ErrorKind::corrupt,
                            "its bytes were changed since they were copied: " +
                                parts_text(plan, damaged) + "; no part is removed",
                            path));
  }
  std::vector<PartPlace> missing = uncopied_parts(layout, storage, path);
  std::erase_if(missing, is_there);
  if (missing.empty()) return;
  throw about_parts(plan, missing,
                    Error(ErrorKind::io,
                          "missing: " + parts_text(plan, missing) + "; no part is removed", path));
}

}  // namespace

std::uint64_t consume_parts(const BuildPlan& plan, const std::vector<std::string>& paths,
                            Storage& storage, const std::string& path, bool overwrite,
                            const PartWork& work, Progress& progress,
                            ClippedVoxels* clipped) {
  if (is_consumed(plan, paths, storage, path, overwrite)) {
    if (clipped != nullptr) *clipped = clipped_of_marks(plan, storage, path);
    const auto lock = storage.lock_folder(folder_of(path));
    leave_done_mark(plan, storage, path);
    return storage.open_read(path)->size();
  }
  std::vector<std::shared_ptr<PartFile>> parts;
  for (const std::string& name : paths) {
    if (storage.exists(name)) parts.push_back(PartFile::open(storage, name));
  }
  std::ranges::sort(parts, {}, [](const auto& part) { return begin_of(part->place()); });
  auto lock = lock_of_consumer(parts, storage);
  check_target(storage, path, overwrite);
  const bool goes_on = find_layout(plan, storage, path).has_value();
  prove_all(parts, progress);
  const JoinLayout layout = lay_out_join(plan, parts, storage, path, overwrite, work, progress);
  if (clipped != nullptr) *clipped = layout.clipped;
  const bool has_copies =
      uncopied_parts(layout, storage, path).size() < parts_of(layout).size();
  if (goes_on || has_copies) {
    require_copies_or_parts(plan, layout, parts, storage, path, work, progress);
  }
  auto left = parts;
  const CopiedMarks marks(layout, storage, path);
  std::erase_if(left, [&](const auto& part) { return marks.hold(part->place()); });
  // Without a word of the disk on what was begun the copies themselves tell.
  const auto begun = goes_on ? begun_bytes(layout, storage, path) : std::optional<std::uint64_t>(0);
  if (begun) require_room(storage, path, left, *begun);
  const PartCopier copier(plan, layout, storage, path);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    // While a part is locked its blocks are not free.
    auto next = lock_of_consumer(std::span(parts).subspan(i + 1), storage);
    copier.copy(parts[i], true, progress);
    lock = std::move(next);
  }
  const auto folder_lock = storage.lock_folder(folder_of(path));
  const std::uint64_t bytes = name_joined(plan, storage, path, overwrite);
  leave_done_mark(plan, storage, path);
  return bytes;
}

}  // namespace octavo
