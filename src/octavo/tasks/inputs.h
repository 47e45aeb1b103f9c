// The .8vo files that tasks read: paths and URLs alike.
#pragma once

#include <memory>
#include <string>

#include "octavo/file/reader.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// True when `path` names an .8vo file by its extension, or is a URL.
bool is_octavo_path(const std::string& path);

/// The bytes of a file or URL; the context says how long its server may take and hears of waiting.
/// Throws as open_any
std::shared_ptr<const ByteSource> open_input(const std::string& path, const TaskContext& context);

/// Opens an .8vo file or an http(s) URL of one, with a cache that fits the memory limit.
/// The watcher of the context ends every reading of voxels.
/// Throws what FileReader::open throws; Error{io} for a folder; as require_voxels
std::shared_ptr<FileReader> open_volume(const std::string& path, const TaskContext& context);

/// "keeps 12 attributes that may tell who, where or when": what a file says of the identity of its
/// source, in words; empty where it keeps none.
std::string kept_identity_words(const FileReader& reader);

/// What a label map is opened as: for the words of the error and the field that it is about.
struct LabelUse {
  const char* what;
  const char* field;
};
inline constexpr LabelUse kAsMask = {"a mask", "mask.kind"};
inline constexpr LabelUse kAsLabels = {"labels", "labels.kind"};

/// open_volume for label maps alone. Throws Error{invalid_argument} for grey volumes as well.
std::shared_ptr<FileReader> open_labels(const std::string& path, const TaskContext& context,
                                        const LabelUse& use);

}  // namespace octavo
