#include "octavo/tasks/files/publish.h"

#include <algorithm>
#include <optional>
#include <set>
#include <span>
#include <string_view>

#include "octavo/core/error.h"
#include "octavo/core/url_text.h"
#include "octavo/file/storage/read_twice.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/verify.h"
#include "octavo/io/serve/request_head.h"
#include "octavo/tasks/files/verify_volume.h"
#include "octavo/tasks/files/web_page.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/surfaces/part_folder.h"

namespace octavo {

namespace {

constexpr std::size_t kCopiedBytes = std::size_t{1} << 20;
constexpr std::uint64_t kMaxListBytes = std::uint64_t{1} << 24;

/// Copies a file into a folder as `name`.
PublishedFile copy_into(PartFolder& folder, const ByteSource& source, const std::string& name,
                        Progress& progress) {
  const std::uint64_t bytes = folder.add(name, [&](PendingFile& file) {
    std::vector<std::uint8_t> part(kCopiedBytes);
    for (std::uint64_t at = 0; at < source.size();) {
      if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      const auto length =
          static_cast<std::size_t>(std::min<std::uint64_t>(kCopiedBytes, source.size() - at));
      const std::span<std::uint8_t> bytes_of_part(part.data(), length);
      source.read(at, bytes_of_part);
      file.append(bytes_of_part);
      at += length;
      progress.advance(static_cast<std::int64_t>(length));
    }
  });
  return {name, bytes};
}

/// Proves every checksum of a volume that was copied, of which the bytes may have changed on their
/// way as well.
/// name  what the errors call it
void require_sound(const std::shared_ptr<const ByteSource>& copy, const std::string& name,
                   const TaskContext& context) {
  VerifyOptions options = verify_options(context);
  options.decode = false;
  options.max_listed = 1;
  const auto report = [&] {
    try {
      return verify_file(copy, options, context.watcher());
    } catch (const Error& error) {
      throw retold(error, error.kind(), error.detail(), name);
    }
  }();
  if (report.is_sound()) return;
  const Damage& first = report.damages.front();
  const std::string others =
      report.damage_count == 1
          ? ""
          : "; " + std::to_string(report.damage_count) + " places are damaged in all";
  const Error failure(ErrorKind::corrupt, first.detail + others, name, first.offset);
  const bool helps_repair = !is_url(name) && report.repairable_count == report.damage_count;
  throw helps_repair ? failure.with_field("input.repair") : failure;
}

/// Copies a volume into a folder as `name` and proves the copy: once more where bytes were changed
/// on their way.
PublishedFile copy_sound(PartFolder& folder, const ByteSource& volume, const std::string& name,
                         const TaskContext& context) {
  const ByteRange all{0, volume.size()};
  return read_twice(volume, {&all, 1}, [&] {
    folder.take_back(name);
    PublishedFile copied;
    {
      ProgressScope progress(context.watcher(), "publish",
                             static_cast<std::int64_t>(volume.size()), "bytes");
      copied = copy_into(folder, volume, name, context.watcher());
    }
    require_sound(folder.open(name), volume.name(), context);
    return copied;
  });
}

/// Whether the file of a row stands in a folder; true of what stands elsewhere.
bool is_still_there(Storage& storage, const std::string& folder, const WebListRow& row) {
  if (is_url(row.url) || row.url.find('/') != std::string::npos) return true;
  const std::optional<std::string> name = percent_decoded(row.url);
  return name && storage.exists(folder + "/" + *name);
}

/// What the list of an earlier page names besides `rows`.
std::vector<WebListRow> earlier_rows(Storage& storage, const std::string& folder,
                                     const std::vector<WebListRow>& rows,
                                     const TaskContext& context) {
  const std::string path = folder + "/" + kWebListName;
  if (!storage.exists(path)) return {};
  std::vector<WebListRow> earlier;
  try {
    const auto source = open_byte_source(storage, path);
    if (source->size() > kMaxListBytes) {
      throw Error(ErrorKind::limit_exceeded, "more than 16 MB");
    }
    std::string list(static_cast<std::size_t>(source->size()), '\0');
    source->read(0, {reinterpret_cast<std::uint8_t*>(list.data()), list.size()});
    earlier = read_web_list(list);
  } catch (const Error&) {
    context.warn(path + " was no list of volumes; it is replaced");
    return {};
  }
  std::set<std::string> urls;
  for (const WebListRow& row : rows) urls.insert(row.url);
  std::erase_if(earlier, [&](const WebListRow& row) {
    return !urls.insert(row.url).second || !is_still_there(storage, folder, row);
  });
  return earlier;
}

}  // namespace

PublishResult publish(const PublishOptions& options, const TaskContext& context) {
  // Prove everything first.
  const std::vector<std::string> page = web_page_files(options.page_folder);
  const std::vector<std::string> names = web_names(options.inputs, page);
  std::vector<std::shared_ptr<const ByteSource>> volumes;
  for (const std::string& path : options.inputs) {
    const auto reader = open_volume(path, context);
    if (const std::string kept = kept_identity_words(*reader);
        !kept.empty() && !options.keep_identity) {
      throw Error(ErrorKind::invalid_argument, kept, public_name(path))
          .with_field("publish.keep_identity");
    }
    volumes.push_back(open_input(path, context));
  }
  Storage& storage = local_storage();
  PartFolder folder(storage, options.output.path, options.output.overwrite);
  for (const std::string& name : page) folder.require_free(name);
  for (const std::string& name : names) folder.require_free(name);
  folder.require_free(kWebListName);

  // Volumes, page, list.
  PublishResult result;
  for (std::size_t i = 0; i < names.size(); ++i) {
    result.volumes.push_back(copy_sound(folder, *volumes[i], names[i], context));
  }
  NoProgress uncounted;
  for (const std::string& name : page) {
    const auto source = open_byte_source(storage, options.page_folder + "/" + name);
    result.page.push_back(copy_into(folder, *source, name, uncounted));
  }
  std::vector<WebListRow> rows = web_rows(names);
  for (WebListRow& row : earlier_rows(storage, options.output.path, rows, context)) {
    result.listed.push_back(row.title);
    rows.push_back(std::move(row));
  }
  const std::string list = web_list(rows);
  const auto list_source = byte_source_of({list.begin(), list.end()}, kWebListName);
  result.page.push_back(copy_into(folder, *list_source, kWebListName, uncounted));
  folder.publish();
  return result;
}

}  // namespace octavo
