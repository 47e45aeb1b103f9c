#include "octavo/file/write/interrupted.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/text.h"
#include "octavo/file/storage/temporary.h"

namespace octavo {

namespace {

constexpr std::size_t kReadBytes = std::size_t{1} << 20;
constexpr std::uint32_t kMaxBlockBytes = std::uint32_t{1} << 20;

template <class Numbers>
std::string numbers_text(const Numbers& numbers) {
  std::string text;
  for (const double number : numbers) text += (text.empty() ? "" : " ") + exact_text(number);
  return text;
}

// Blocks of streams that such a volume has.
bool are_known(const std::vector<JournalBlock>& blocks, const Levels& levels) {
  const auto is_known = [&](const JournalBlock& block) {
    return block.stream <= static_cast<std::size_t>(levels.count()) &&
           block.length <= kMaxBlockBytes;
  };
  return std::ranges::all_of(blocks, is_known);
}

// Takes the next line "NAME: VALUE" off the front of `lines`.
std::pair<std::string_view, std::string_view> take_line(std::string_view& lines) {
  const std::string_view line = lines.substr(0, lines.find('\n'));
  lines.remove_prefix(std::min(lines.size(), line.size() + 1));
  const std::size_t colon = line.find(": ");
  if (colon == std::string_view::npos) return {line, {}};
  return {line.substr(0, colon), line.substr(colon + 2)};
}

// What stands around byte `at` of a long text.
std::string excerpt(const std::string& text, std::size_t at) {
  constexpr std::size_t kBefore = 24;
  constexpr std::size_t kLength = 64;
  const std::size_t from = at > kBefore ? at - kBefore : 0;
  return "'" + escaped(text.substr(std::min(from, text.size()), kLength)) + "'";
}

// A setting that an option gives.
struct AskedSetting {
  std::string_view name;  // in the journal
  const char* words;
  const char* field;      // of the options, when they continue a build
};

constexpr AskedSetting kAskedSettings[] = {
    {"access", "access", "interrupted.access"},
    {"keep_details", "level of details", "interrupted.keep_details"},
    {"max error", "max error", "interrupted.max_error"},
    {"max_error", "max error", "interrupted.max_error"},
    {"preset", "preset", "interrupted.preset"},
    {"repair.infinity", "replacement of infinities", "interrupted.repair.infinity"},
    {"repair.nan", "replacement of NaN", "interrupted.repair.nan"},
    {"thumbnail", "thumbnail", "interrupted.thumbnail"},
};

Error other_setting(std::string_view name, const std::string& stored, const std::string& now) {
  const auto asked = std::ranges::find(kAskedSettings, name, &AskedSetting::name);
  const bool is_asked = asked != std::end(kAskedSettings);
  const Error error(ErrorKind::invalid_argument,
                    "the interrupted build has another " +
                        (is_asked ? std::string(asked->words) : escaped(name)) + ": " + stored +
                        " there, " + now + " now");
  if (!is_asked) return error;
  return error.with_field(asked->field, stored == kSettingNotGiven ? "" : stored);
}

}  // namespace

std::uint32_t crc_of(const StorageFile& file, std::uint64_t begin, std::uint64_t end,
                     std::uint32_t crc) {
  Bytes buffer(kReadBytes);
  while (begin < end) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(kReadBytes, end - begin));
    const auto part = std::span(buffer).first(count);
    file.read(begin, part);
    crc = crc32c(part, crc);
    begin += count;
  }
  return crc;
}

std::vector<InterruptedBuild> find_interrupted(Storage& storage, const std::string& path,
                                               std::vector<std::string>* held) {
  std::vector<InterruptedBuild> found;
  const std::string ending = kJournalEnding;
  for (const std::string& name : list_temporaries(storage, path)) {
    if (!name.ends_with(ending)) continue;
    const std::string file = name.substr(0, name.size() - ending.size());
    if (!storage.exists(file)) continue;
    InterruptedBuild build;
    build.journal = storage.open_update(name);
    if (build.journal) build.file = storage.open_update(file);
    if (!build.file) {
      const bool is_there = storage.exists(name) && storage.exists(file);
      if (held != nullptr && is_there) held->push_back(file);
      continue;
    }
    auto head = read_journal_head(*build.journal);
    if (!head) continue;
    build.head = std::move(*head);
    found.push_back(std::move(build));
  }
  return found;
}

void discard_interrupted(Storage& storage, const std::string& path) noexcept {
  try {
    for (const InterruptedBuild& build : find_interrupted(storage, path)) {
      storage.remove(build.file->path());
      storage.remove(build.journal->path());
    }
  } catch (const std::exception&) {
    // What stays does no harm.
  }
}

bool follows(const JournalGroup& group, const JournalGroup& before, const Levels& levels) {
  const Size3 grid = levels.brick_grid(0);
  const std::int64_t layers = group.end_layer - before.end_layer;
  if (layers <= 0 || group.end_layer > grid.z || group.file_bytes < before.file_bytes) return false;
  const bool is_sum = group.squared_error >= before.squared_error &&
                      group.squared_error <= std::numeric_limits<double>::max();
  if (!is_sum) return false;
  const auto layer_bricks = static_cast<std::uint64_t>(grid.x * grid.y);
  const std::uint64_t layer_pages = (layer_bricks + kPageBricks - 1) / kPageBricks;
  const auto count = static_cast<std::uint64_t>(layers);
  const auto is_inside = [&](const ModelRef& model) {
    return model.first_slab >= before.end_layer && model.first_slab < group.end_layer &&
           model.length <= kMaxModelBytes;
  };
  const std::int64_t planes =
      planes_in(levels, group.end_layer) - planes_in(levels, before.end_layer);
  const bool has_first = !group.models.empty() && group.models.front().first_slab == 0;
  if (!std::ranges::all_of(group.models, is_inside) || (before.end_layer == 0 && !has_first)) {
    return false;
  }
  return group.slab_trailer_bytes.size() == count && group.pages.size() == count * layer_pages &&
         group.parents.size() == count * layer_bricks &&
         group.plane_digests.size() == static_cast<std::uint64_t>(planes);
}

std::vector<WholeGroup> proven_groups(const StorageFile& file, const StorageFile& journal,
                                      const Levels& levels) {
  std::vector<WholeGroup> groups = read_journal_groups(journal);
  const std::uint64_t size = file.size();
  JournalGroup before;
  before.file_bytes = kHeaderBytes;
  std::size_t whole = 0;
  for (const auto& [group, blocks, end] : groups) {
    const bool is_known = follows(group, before, levels) && are_known(blocks, levels);
    if (!is_known || group.file_bytes > size) break;
    if (crc_of(file, before.file_bytes, group.file_bytes, before.digest) != group.digest) break;
    before.end_layer = group.end_layer;
    before.file_bytes = group.file_bytes;
    before.digest = group.digest;
    before.squared_error = group.squared_error;
    ++whole;
  }
  groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(whole), groups.end());
  return groups;
}

std::vector<WholeGroup> proven_groups(const InterruptedBuild& build) {
  try {
    const FileHeader header = parse_unsealed_header(build.head.header);
    const Levels levels(header.description.size, header.halvings);
    return proven_groups(*build.file, *build.journal, levels);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::io || error.kind() == ErrorKind::out_of_memory) throw;
    return {};
  }
}

void reject_interrupted(Storage& storage, const std::string& path) {
  for (const InterruptedBuild& build : find_interrupted(storage, path)) {
    const auto groups = proven_groups(build);
    if (groups.empty()) continue;
    const FileHeader header = parse_unsealed_header(build.head.header);
    const Levels levels(header.description.size, header.halvings);
    throw Error(ErrorKind::io,
                "an interrupted build of it is here (" +
                    planes_text(0, planes_in(levels, groups.back().group.end_layer),
                                levels.size(0).z) +
                    ")",
                path)
        .with_field("interrupted");
  }
}

void reject_running(Storage& storage, const std::string& path) {
  std::vector<std::string> held;
  find_interrupted(storage, path, &held);
  if (held.empty()) return;
  throw Error(ErrorKind::io,
              "is being built by another program (" + escaped(base_name_of(held.front())) +
                  " is locked, or may not be locked and written by this one); wait for its end or "
                  "name another file",
              path)
      .with_field("interrupted", "discard");
}

std::string settings_of(const FileHeader& header) {
  const VolumeDescription& volume = header.description;
  std::string lines;
  const auto add = [&](const std::string& name, const std::string& value) {
    lines.append(name).append(": ").append(value).append("\n");
  };
  add("kind", volume.kind == VolumeKind::labels ? "labels" : "grey");
  add("voxel type", std::string(voxel_type_name(volume.type)));
  const Size3& size = volume.size;
  add("size", std::to_string(size.x) + " x " + std::to_string(size.y) + " x " +
                  std::to_string(size.z));
  add("spacing", numbers_text(volume.geometry.spacing_mm));
  add("origin", numbers_text(volume.geometry.origin_mm));
  add("direction", numbers_text(volume.geometry.direction));
  add("slope", exact_text(volume.rescale.slope));
  add("intercept", exact_text(volume.rescale.intercept));
  add("max error", exact_text(header.max_error));
  if (volume.coding) {
    add("float coding", std::string(voxel_type_name(volume.coding->type)) + " * " +
                            exact_text(volume.coding->scale) + " + " +
                            exact_text(volume.coding->offset));
  }
  return lines;
}

std::optional<Error> difference_of(const JournalHead& stored, const JournalHead& now) {
  std::string_view stored_lines = stored.settings;
  std::string_view now_lines = now.settings;
  while (!stored_lines.empty() || !now_lines.empty()) {
    const auto [was_name, was] = take_line(stored_lines);
    const auto [is_name, is] = take_line(now_lines);
    if (was_name != is_name) {
      return other_setting("list of settings", escaped(was_name), escaped(is_name));
    }
    if (was != is) return other_setting(is_name, escaped(was), escaped(is));
  }
  if (stored.metadata != now.metadata) {
    const auto [a, b] = std::ranges::mismatch(stored.metadata, now.metadata);
    const auto at = static_cast<std::size_t>(a - stored.metadata.begin());
    return other_setting("description of the source", excerpt(stored.metadata, at),
                         excerpt(now.metadata, at));
  }
  if (stored.header != now.header) {
    return Error(ErrorKind::source_rejected,
                 "the first planes hold other voxels than those of the interrupted build");
  }
  return std::nullopt;
}

std::int64_t planes_in(const Levels& levels, std::int64_t layers) {
  return std::min(layers * levels.brick_side(0).z, levels.size(0).z);
}

std::string planes_text(std::int64_t first, std::int64_t end, std::int64_t count) {
  return "planes " + std::to_string(first) + " to " + std::to_string(end - 1) + " of " +
         std::to_string(count);
}

}  // namespace octavo
