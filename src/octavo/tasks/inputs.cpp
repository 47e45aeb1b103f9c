#include "octavo/tasks/inputs.h"

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/url_text.h"
#include "octavo/file/storage/storage.h"
#include "octavo/io/http/http_source.h"
#include "octavo/tasks/files/decoding_memory.h"

namespace octavo {

namespace {

/// What the index of most files fits into, with what is read before it.
constexpr std::uint64_t kEndBytes = ReaderOptions().lead_bytes + (std::uint64_t{1} << 16);

}  // namespace

bool is_octavo_path(const std::string& path) { return is_url(path) || path.ends_with(".8vo"); }

std::shared_ptr<const ByteSource> open_input(const std::string& path,
                                             const TaskContext& context) {
  HttpOptions options;
  options.timeout_s = context.timeout_s;
  options.on_wait = [note = context.on_note](const std::string& text) {
    if (note) note(text, "timeout_s");
  };
  options.is_cancelled = [watcher = context.progress] {
    return watcher != nullptr && watcher->is_cancelled();
  };
  options.end_bytes = kEndBytes;
  return open_any(path, options);
}

std::shared_ptr<FileReader> open_volume(const std::string& path, const TaskContext& context) {
  ReaderOptions options;
  options.cache_bytes = cache_bytes(context);
  if (!is_url(path) && local_storage().path_type(path) == PathType::folder) {
    throw Error(ErrorKind::io, "is a folder, not an 8vo file", path).with_field("input.format");
  }
  options.watcher = context.progress;
  std::shared_ptr<FileReader> reader = FileReader::open(open_input(path, context), options);
  context.require_voxels(reader->description().size, reader->source().name());
  return reader;
}

std::string kept_identity_words(const FileReader& reader) {
  const Metadata& metadata = reader.description().metadata;
  if (!metadata.keeps_identity()) return "";
  const auto count = static_cast<std::int64_t>(metadata.facts().identity->attributes->size());
  return "keeps " + counted_text(count, "attribute") + " that may tell who, where or when";
}

std::shared_ptr<FileReader> open_labels(const std::string& path, const TaskContext& context,
                                        const LabelUse& use) {
  std::shared_ptr<FileReader> reader = open_volume(path, context);
  if (reader->description().kind == VolumeKind::labels) return reader;
  throw Error(ErrorKind::invalid_argument, std::string("holds grey values, not ") + use.what, path)
      .with_field(use.field);
}

}  // namespace octavo
