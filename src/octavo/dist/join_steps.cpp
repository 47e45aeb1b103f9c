#include "octavo/dist/join_steps.h"

#include <algorithm>
#include <map>
#include <optional>
#include <random>
#include <span>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/dist/clipped_bytes.h"
#include "octavo/file/storage/temporary.h"

namespace octavo {

namespace {

constexpr std::uint64_t kMostLayoutBytes = std::uint64_t{1} << 30;
constexpr std::uint64_t kMostMarkBytes = 256;
constexpr std::uint64_t kMostLineBytes = 160;  // of a run
constexpr std::uint64_t kMostHeadBytes = 512;  // of what stands before the runs
constexpr const char* kLayoutEnding = "-layout";
constexpr const char* kCopiedEnding = "-copied-";
constexpr const char* kSealedEnding = "-sealed-";
constexpr const char* kDoneEnding = "-done-";

/// What joins leave beside a name: ".NAME.join" and an ending, the longest that of a copied band,
/// which has five numbers.
std::string join_prefix(const std::string& path) {
  constexpr std::size_t kMostDigits = 20;
  constexpr std::size_t kLongestEnding =
      std::string_view(".join-copied-").size() + 5 * kMostDigits + 4;
  return hidden_prefix(path, kLongestEnding) + ".join";
}

std::string layout_name(const std::string& path) { return join_prefix(path) + kLayoutEnding; }

/// The mark of a part that was copied for this layout: those of an earlier one say nothing of this
/// file.
std::string copied_name(const JoinLayout& layout, const std::string& path,
                        const PartPlace& place) {
  std::string name = join_prefix(path) + kCopiedEnding + std::to_string(layout.id) + "-" +
                     std::to_string(place.first_group) + "-" + std::to_string(place.end_group);
  if (place.is_band()) {
    name += "-" + std::to_string(place.first_brick) + "-" + std::to_string(place.end_brick);
  }
  return name;
}

std::string sealed_name(const std::string& path, const BuildPlan& plan) {
  return join_prefix(path) + kSealedEnding + std::to_string(plan.id);
}

std::string done_name(const std::string& path, const BuildPlan& plan) {
  return join_prefix(path) + kDoneEnding + std::to_string(plan.id);
}

/// Of one laying out: two of the same plan differ in nothing else.
std::uint64_t new_layout_id() {
  std::random_device device;
  return std::uint64_t{device()} << 32 | device();
}

/// A file of these bytes under a name, whole or not at all.
void put_file(Storage& storage, const std::string& name, std::string_view bytes) {
  TemporaryFile temporary = create_temporary(storage, name);
  try {
    temporary.file->write(0, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    temporary.file->sync();
    temporary.file->close();
    storage.rename(temporary.path, name);
  } catch (...) {
    remove_quietly(storage, temporary.path);
    throw;
  }
  storage.sync_folder(folder_of(name));
}

/// Throws Error{corrupt} for a file of more bytes
std::string file_text(Storage& storage, const std::string& name, std::uint64_t most) {
  const std::unique_ptr<StorageFile> file = storage.open_read(name);
  if (file->size() > most) throw Error(ErrorKind::corrupt, "the layout is longer than any");
  std::string text(static_cast<std::size_t>(file->size()), '\0');
  file->read(0, {reinterpret_cast<std::uint8_t*>(text.data()), text.size()});
  return text;
}

void remove_all(Storage& storage, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (storage.exists(name)) storage.remove(name);
  }
}

/// Everything with which joins to `path` grow. The marks of copies go first: a layout without them
/// is copied anew, marks without a layout would say what is not so. That of the plan goes last: it
/// says that all is done.
void discard_join(Storage& storage, const std::string& path) {
  std::vector<std::string> names = storage.list(join_prefix(path) + kCopiedEnding);
  names.push_back(layout_name(path));
  names.push_back(joined_name(path));
  const std::vector<std::string> sealed = storage.list(join_prefix(path) + kSealedEnding);
  names.insert(names.end(), sealed.begin(), sealed.end());
  remove_all(storage, names);
  storage.sync_folder(folder_of(path));
}

/// Names the file that was asked for, where a failure names the one that grows for it.
template <class F>
auto about(const std::string& path, F action) -> decltype(action()) {
  try {
    return action();
  } catch (const Error& error) {
    const bool is_growing = error.path() == joined_name(path);
    throw is_growing ? error.with_path(path) : error;
  }
}

/// The most bytes that the layout of a plan has: each group a part, or the parts that share groups,
/// with all their streams.
std::uint64_t most_layout_bytes(const BuildPlan& plan) {
  const std::size_t streams = run_streams(outline_of(plan).levels);
  const auto parts = static_cast<std::uint64_t>(std::max(plan.group_count, plan.part_count));
  return parts * streams * kMostLineBytes + kMostHeadBytes;
}

/// The same of a layout of the plan itself, beside which parts are marked as copied.
std::string why_kept_of_plan(const JoinLayout& layout, Storage& storage, const std::string& path) {
  if (!storage.exists(joined_name(path))) return {};
  const std::uint64_t bytes = storage.open_read(joined_name(path))->size();
  if (bytes == layout.file_bytes) return {};
  const std::string growing = escaped(joined_name(path));
  return growing + ", in which a join has begun, has " + std::to_string(bytes) + " bytes, " +
         std::to_string(layout.file_bytes) +
         " expected: it may be all that is left of parts that were copied; where they are still "
         "there, or can be made again, remove " + growing + "*";
}

/// Why what stands beside this name is not this join's to remove: it may be all that is left of
/// parts that are gone. Empty where it may be removed.
std::string why_kept(const BuildPlan& plan, Storage& storage, const std::string& path) {
  if (!storage.exists(layout_name(path))) return {};
  if (storage.list(join_prefix(path) + kCopiedEnding).empty()) return {};
  const std::string growing = escaped(joined_name(path));
  try {
    const JoinLayout layout =
        parse_layout(file_text(storage, layout_name(path), kMostLayoutBytes));
    if (layout.plan == plan.id) return why_kept_of_plan(layout, storage, path);
    return "a join by another plan has begun here (" + growing +
           " and what is called so); finish it, or remove that";
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::io) throw;
    if (!storage.exists(joined_name(path))) return {};
    return "a join has begun here whose layout cannot be read (" + error.detail() + "): " +
           growing + " may be all that is left of parts that were copied; where they are still "
           "there, or can be made again, remove " + growing + "*";
  }
}

/// A join that was not finished may be all that is left of parts that are gone.
void require_none_of_others(const BuildPlan& plan, Storage& storage, const std::string& path) {
  const std::string why = why_kept(plan, storage, path);
  if (!why.empty()) throw Error(ErrorKind::io, why, path);
}

/// What the end of a file says of all its bytes; empty for what is too short.
std::string end_of(Storage& storage, const std::string& path) {
  if (storage.path_type(path) != PathType::file) return {};
  const std::unique_ptr<StorageFile> file = storage.open_read(path);
  if (file->size() < kHeaderBytes + kTrailerBytes) return {};
  std::string end(static_cast<std::size_t>(kTrailerBytes), '\0');
  file->read(file->size() - kTrailerBytes,
             {reinterpret_cast<std::uint8_t*>(end.data()), end.size()});
  return end;
}

/// Whether the file at `path` is the one for which this mark was left.
bool is_marked(Storage& storage, const std::string& mark, const std::string& path) {
  if (!storage.exists(mark) || !storage.exists(path)) return false;
  const std::string end = end_of(storage, path);
  return !end.empty() && file_text(storage, mark, kMostMarkBytes).starts_with(end);
}

/// Whether two whole files hold the same, by their lengths and what their ends say of all bytes.
bool is_same_file(Storage& storage, const std::string& a, const std::string& b) {
  const std::string end = end_of(storage, a);
  return !end.empty() && end == end_of(storage, b) &&
         storage.open_read(a)->size() == storage.open_read(b)->size();
}

/// What a mark is to hold of the file at `path`.
std::string mark_of(Storage& storage, const std::string& path, const ClippedVoxels& clipped) {
  const std::string end = end_of(storage, path);
  if (end.empty()) throw Error(ErrorKind::io, "is no whole file", path);
  const Bytes counts = clipped_bytes(clipped);
  return end + std::string(counts.begin(), counts.end());
}

/// Requires the mark of a plan whose file is_joined.
ClippedVoxels clipped_of_marks(const BuildPlan& plan, Storage& storage, const std::string& path) {
  const std::string sealed = sealed_name(path, plan);
  const std::string& mark = is_marked(storage, sealed, path) ? sealed : done_name(path, plan);
  const std::string text = file_text(storage, mark, kMostMarkBytes);
  ByteSpan bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  bytes = bytes.subspan(kTrailerBytes);
  return take_clipped(bytes, "the mark of a join");
}

void prove_all(const std::vector<std::shared_ptr<PartFile>>& parts, Progress& progress) {
  std::uint64_t bytes = 0;
  for (const auto& part : parts) bytes += part->stream_bytes();
  const WatchedParts watched(parts, progress);
  const ProgressScope scope(progress, "check parts", static_cast<std::int64_t>(bytes), "bytes");
  for (const auto& part : parts) part->prove();
}

/// The parts that were copied for a layout, looked up at once.
class CopiedMarks {
 public:
  CopiedMarks(const JoinLayout& layout, Storage& storage, const std::string& path)
      : layout_(layout), path_(path), names_(storage.list(join_prefix(path) + kCopiedEnding)) {
    std::ranges::sort(names_);
  }
  bool hold(const PartPlace& place) const {
    return std::ranges::binary_search(names_, copied_name(layout_, path_, place));
  }

 private:
  const JoinLayout& layout_;
  const std::string& path_;
  std::vector<std::string> names_;
};

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

/// Gives the file that was laid out its name, and marks it as sealed; where it has its name already
/// nothing is done. Returns its length
std::uint64_t name_joined(const BuildPlan& plan, Storage& storage, const std::string& path,
                          bool overwrite) {
  const std::optional<JoinLayout> layout = find_layout(plan, storage, path);
  if (!layout) return storage.open_read(path)->size();
  const std::vector<PartPlace> missing = uncopied_parts(*layout, storage, path);
  if (!missing.empty()) {
    std::string text;
    for (const PartPlace& place : missing) text += (text.empty() ? "" : ", ") + place_text(place);
    throw Error(ErrorKind::io, "parts were not copied: those of " + text, path);
  }
  const std::string growing = joined_name(path);
  try {
    // Another join of these parts may have made the file meanwhile: one takes the other's place.
    const bool replaces = overwrite || is_same_file(storage, growing, path);
    check_target(storage, path, replaces);
    put_file(storage, sealed_name(path, plan), mark_of(storage, growing, layout->clipped));
    if (replaces) storage.rename(growing, path);
    else storage.rename_new(growing, path);
  } catch (const Error&) {
    // Where folders have no locks another program may have sealed it meanwhile.
    if (storage.exists(growing) || !is_joined(plan, storage, path)) throw;
  }
  storage.sync_folder(folder_of(path));
  return layout->file_bytes;
}

/// Leaves of all marks beside a joined file the one that says of what plan it is. Requires the
/// lock of the folder.
void leave_done_mark(const BuildPlan& plan, Storage& storage, const std::string& path) {
  const std::string done = done_name(path, plan);
  if (!is_marked(storage, done, path)) {
    put_file(storage, done, file_text(storage, sealed_name(path, plan), kMostMarkBytes));
  }
  std::vector<std::string> older = storage.list(join_prefix(path) + kDoneEnding);
  std::erase(older, done);
  remove_all(storage, older);
  if (why_kept(plan, storage, path).empty()) discard_join(storage, path);
}

}  // namespace

std::string joined_name(const std::string& path) { return join_prefix(path); }

bool is_sealed(const BuildPlan& plan, Storage& storage, const std::string& path) {
  return is_marked(storage, sealed_name(path, plan), path) && !find_layout(plan, storage, path);
}

bool is_joined(const BuildPlan& plan, Storage& storage, const std::string& path) {
  return is_sealed(plan, storage, path) || is_marked(storage, done_name(path, plan), path);
}

bool is_consumed(const BuildPlan& plan, const std::vector<std::string>& paths, Storage& storage,
                 const std::string& path, bool overwrite) {
  const auto is_there = [&](const std::string& part) { return storage.exists(part); };
  return is_joined(plan, storage, path) &&
         (!overwrite || std::ranges::none_of(paths, is_there));
}

void discard_steps(const BuildPlan& plan, Storage& storage, const std::string& path) {
  if (storage.list(joined_name(path)).empty()) return;
  // Nobody says of a part that it is copied between the look and the removal.
  const auto lock = storage.lock_folder(folder_of(path));
  if (!why_kept(plan, storage, path).empty()) return;
  remove_all(storage, storage.list(join_prefix(path) + kDoneEnding));
  discard_join(storage, path);
}

std::optional<JoinLayout> find_layout(const BuildPlan& plan, Storage& storage,
                                      const std::string& path) {
  if (!storage.exists(layout_name(path)) || !storage.exists(joined_name(path))) {
    return std::nullopt;
  }
  try {
    JoinLayout layout =
        parse_layout(file_text(storage, layout_name(path), most_layout_bytes(plan)));
    const bool is_whole =
        storage.open_read(joined_name(path))->size() == layout.file_bytes;
    if (layout.plan == plan.id && is_whole) return layout;
  } catch (const Error& error) {
    // Both go while another program seals.
    const bool is_there = storage.exists(layout_name(path)) && storage.exists(joined_name(path));
    if (error.kind() == ErrorKind::io && is_there) throw;
  }
  return std::nullopt;
}

JoinLayout lay_out_join(const BuildPlan& plan, const std::vector<std::shared_ptr<PartFile>>& parts,
                        Storage& storage, const std::string& path, bool overwrite,
                        const PartWork& work, Progress& progress) {
  check_target(storage, path, overwrite);
  {
    // Nobody else's layout may come, with parts copied into it, between the look and the removal.
    const auto lock = storage.lock_folder(folder_of(path));
    if (std::optional<JoinLayout> layout = find_layout(plan, storage, path)) return *layout;
    require_none_of_others(plan, storage, path);
    discard_join(storage, path);
  }
  JoinLayout layout;
  layout.plan = plan.id;
  layout.id = new_layout_id();
  const BuildResult result = about(path, [&] {
    // What somebody else has laid out meanwhile may hold parts already: it stays.
    return lay_out_parts(plan, parts, storage, joined_name(path), false, work, progress,
                         [&](const PartFile& part, std::size_t stream, const Section& bytes) {
                           if (bytes.length == 0) return;
                           layout.runs.push_back({part.place(), part.stream(stream).offset,
                                                  bytes.offset, bytes.length, bytes.crc});
                         });
  });
  layout.file_bytes = result.file_bytes;
  layout.clipped = result.clipped;
  put_file(storage, layout_name(path), layout_text(layout));
  return layout;
}

namespace {

/// Whether what stands there is still this layout, and not one of another laying out.
bool is_still_laid_out(const JoinLayout& layout, Storage& storage, const std::string& path) {
  if (!storage.exists(layout_name(path)) || !storage.exists(joined_name(path))) return false;
  const auto file = storage.open_read(layout_name(path));
  std::string head(static_cast<std::size_t>(std::min(file->size(), kMostHeadBytes)), '\0');
  file->read(0, {reinterpret_cast<std::uint8_t*>(head.data()), head.size()});
  return parse_layout_head(head).id == layout.id &&
         storage.open_read(joined_name(path))->size() == layout.file_bytes;
}

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
  if (is_laid_out && !storage.exists(mark)) put_file(storage, mark, "");
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

  // Their bytes, then the mark that says that they are there
  if (is_copied(place)) {
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

/// Of two joins that consume the same parts the second one ends here, before it lays anything out:
/// neither could get all of them.
std::unique_ptr<StorageFile> lock_of_consumer(const std::vector<std::shared_ptr<PartFile>>& parts,
                                              Storage& storage) {
  const auto first = std::ranges::min_element(
      parts, {}, [](const auto& part) { return begin_of(part->place()); });
  if (first == parts.end()) return nullptr;
  const std::string& name = (*first)->path();
  std::unique_ptr<StorageFile> lock = storage.lock_left(name);
  if (lock || !storage.is_locked(name)) return lock;
  throw Error(ErrorKind::io,
              "another join that consumes parts works on this one and those behind it", name);
}

}  // namespace

std::vector<PartPlace> uncopied_parts(const JoinLayout& layout, Storage& storage,
                                      const std::string& path) {
  std::vector<PartPlace> places = parts_of(layout);
  const CopiedMarks marks(layout, storage, path);
  std::erase_if(places, [&](const PartPlace& place) { return marks.hold(place); });
  return places;
}

std::uint64_t seal_join(const BuildPlan& plan, Storage& storage, const std::string& path,
                        bool overwrite) {
  // Of two that seal at once the second finds the file sealed.
  const auto lock = storage.lock_folder(folder_of(path));
  if (!find_layout(plan, storage, path) && !is_joined(plan, storage, path)) {
    throw Error(ErrorKind::io, "nothing is laid out for this plan", path);
  }
  const std::uint64_t bytes = name_joined(plan, storage, path, overwrite);
  leave_done_mark(plan, storage, path);
  return bytes;
}

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
  const auto lock = lock_of_consumer(parts, storage);
  check_target(storage, path, overwrite);
  const bool goes_on = find_layout(plan, storage, path).has_value();
  prove_all(parts, progress);
  const JoinLayout layout = lay_out_join(plan, parts, storage, path, overwrite, work, progress);
  if (clipped != nullptr) *clipped = layout.clipped;
  auto left = parts;
  const CopiedMarks marks(layout, storage, path);
  std::erase_if(left, [&](const auto& part) { return marks.hold(part->place()); });
  // Without a word of the disk on what was begun the copies themselves tell.
  const auto begun = goes_on ? begun_bytes(layout, storage, path) : std::optional<std::uint64_t>(0);
  if (begun) require_room(storage, path, left, *begun);
  const PartCopier copier(plan, layout, storage, path);
  for (const auto& part : parts) copier.copy(part, true, progress);
  const auto folder_lock = storage.lock_folder(folder_of(path));
  const std::uint64_t bytes = name_joined(plan, storage, path, overwrite);
  leave_done_mark(plan, storage, path);
  return bytes;
}

}  // namespace octavo
