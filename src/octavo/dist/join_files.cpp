#include "octavo/dist/join_files.h"

#include <algorithm>
#include <string_view>

#include "octavo/core/error.h"
#include "octavo/dist/clipped_bytes.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/write/run_writer.h"

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
constexpr const char* kDraftEnding = "-draft-";

/// What joins leave beside a name: ".NAME.join" and an ending, the longest that of a copied band,
/// which has five numbers.
std::string join_prefix(const std::string& path) {
  constexpr std::size_t kMostDigits = 20;
  constexpr std::size_t kLongestEnding =
      std::string_view(".join-copied-").size() + 5 * kMostDigits + 4;
  return hidden_prefix(path, kLongestEnding) + ".join";
}

std::string done_name(const std::string& path, const BuildPlan& plan) {
  return join_prefix(path) + kDoneEnding + std::to_string(plan.id);
}

std::string text_at(const StorageFile& file, std::uint64_t offset, std::uint64_t bytes) {
  std::string text(static_cast<std::size_t>(bytes), '\0');
  file.read(offset, {reinterpret_cast<std::uint8_t*>(text.data()), text.size()});
  return text;
}

/// Throws Error{corrupt} for a file of more bytes
std::string file_text(Storage& storage, const std::string& name, std::uint64_t most) {
  const std::unique_ptr<StorageFile> file = storage.open_read(name);
  if (file->size() > most) throw Error(ErrorKind::corrupt, "the layout is longer than any");
  return text_at(*file, 0, file->size());
}

void remove_drafts(Storage& storage, const std::string& path) {
  remove_names(storage, storage.list(join_prefix(path) + kDraftEnding));
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

/// What the end of a file says of all its bytes; empty for what is too short.
std::string end_of(Storage& storage, const std::string& path) {
  if (storage.path_type(path) != PathType::file) return {};
  const std::unique_ptr<StorageFile> file = storage.open_read(path);
  if (file->size() < kHeaderBytes + kTrailerBytes) return {};
  return text_at(*file, file->size() - kTrailerBytes, kTrailerBytes);
}

/// Whether the file at `path` is the one for which this mark was left.
bool is_marked(Storage& storage, const std::string& mark, const std::string& path) {
  if (!storage.exists(mark) || !storage.exists(path)) return false;
  const std::string end = end_of(storage, path);
  return !end.empty() && file_text(storage, mark, kMostMarkBytes).starts_with(end);
}

}  // namespace

std::string joined_name(const std::string& path) { return join_prefix(path); }

std::string layout_name(const std::string& path) { return join_prefix(path) + kLayoutEnding; }

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

std::string draft_name(const std::string& path, const BuildPlan& plan) {
  return join_prefix(path) + kDraftEnding + std::to_string(plan.id);
}

CopiedMarks::CopiedMarks(const JoinLayout& layout, Storage& storage, const std::string& path)
    : layout_(layout), path_(path), names_(storage.list(join_prefix(path) + kCopiedEnding)) {
  std::ranges::sort(names_);
}

bool CopiedMarks::hold(const PartPlace& place) const {
  return std::ranges::binary_search(names_, copied_name(layout_, path_, place));
}

void put_join_file(Storage& storage, const std::string& name, std::string_view bytes) {
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

void remove_names(Storage& storage, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (storage.exists(name)) storage.remove(name);
  }
}

void remove_unfinished(Storage& storage, const std::string& path) {
  const std::string prefix = join_prefix(path);
  const std::string hidden =
      prefix.substr(0, prefix.size() - base_name_of(prefix).size()) + "." + base_name_of(prefix);
  constexpr std::string_view kTemporary = ".tmp-";
  for (const std::string& name : storage.list(hidden)) {
    const std::size_t ending = name.rfind(kTemporary);
    if (ending == std::string::npos) continue;
    storage.remove_stale(name.substr(0, ending + kTemporary.size()));
  }
}

void discard_join(Storage& storage, const std::string& path) {
  std::vector<std::string> names = storage.list(join_prefix(path) + kCopiedEnding);
  names.push_back(layout_name(path));
  names.push_back(joined_name(path));
  const std::vector<std::string> sealed = storage.list(join_prefix(path) + kSealedEnding);
  names.insert(names.end(), sealed.begin(), sealed.end());
  remove_names(storage, names);
  storage.sync_folder(folder_of(path));
}

void require_none_of_others(const BuildPlan& plan, Storage& storage, const std::string& path) {
  const std::string why = why_kept(plan, storage, path);
  if (!why.empty()) throw Error(ErrorKind::io, why, path);
}

bool is_same_file(Storage& storage, const std::string& a, const std::string& b) {
  const std::string end = end_of(storage, a);
  return !end.empty() && end == end_of(storage, b) &&
         storage.open_read(a)->size() == storage.open_read(b)->size();
}

std::string joined_mark(Storage& storage, const std::string& path, const ClippedVoxels& clipped) {
  const std::string end = end_of(storage, path);
  if (end.empty()) throw Error(ErrorKind::io, "is no whole file", path);
  const Bytes counts = clipped_bytes(clipped);
  return end + std::string(counts.begin(), counts.end());
}

ClippedVoxels clipped_of_marks(const BuildPlan& plan, Storage& storage, const std::string& path) {
  const std::string sealed = sealed_name(path, plan);
  const std::string& mark = is_marked(storage, sealed, path) ? sealed : done_name(path, plan);
  const std::string text = file_text(storage, mark, kMostMarkBytes);
  ByteSpan bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  bytes = bytes.subspan(kTrailerBytes);
  return take_clipped(bytes, "the mark of a join");
}

void leave_done_mark(const BuildPlan& plan, Storage& storage, const std::string& path) {
  const std::string done = done_name(path, plan);
  if (!is_marked(storage, done, path)) {
    put_join_file(storage, done, file_text(storage, sealed_name(path, plan), kMostMarkBytes));
  }
  std::vector<std::string> older = storage.list(join_prefix(path) + kDoneEnding);
  std::erase(older, done);
  remove_names(storage, older);
  remove_unfinished(storage, path);
  remove_drafts(storage, path);
  if (why_kept(plan, storage, path).empty()) discard_join(storage, path);
}

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
  remove_unfinished(storage, path);
  if (storage.list(joined_name(path)).empty()) return;
  // Nobody says of a part that it is copied between the look and the removal.
  const auto lock = storage.lock_folder(folder_of(path));
  if (!why_kept(plan, storage, path).empty()) return;
  remove_names(storage, storage.list(join_prefix(path) + kDoneEnding));
  remove_drafts(storage, path);
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

bool is_still_laid_out(const JoinLayout& layout, Storage& storage, const std::string& path) {
  if (!storage.exists(layout_name(path)) || !storage.exists(joined_name(path))) return false;
  const auto file = storage.open_read(layout_name(path));
  const std::string head = text_at(*file, 0, std::min(file->size(), kMostHeadBytes));
  return parse_layout_head(head).id == layout.id &&
         storage.open_read(joined_name(path))->size() == layout.file_bytes;
}

std::vector<PartPlace> uncopied_parts(const JoinLayout& layout, Storage& storage,
                                      const std::string& path) {
  std::vector<PartPlace> places = parts_of(layout);
  const CopiedMarks marks(layout, storage, path);
  std::erase_if(places, [&](const PartPlace& place) { return marks.hold(place); });
  return places;
}

}  // namespace octavo
