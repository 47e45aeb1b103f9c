#include "octavo/tasks/pictures/picture_files.h"

#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/storage/temporary.h"

namespace octavo {

void require_png(const std::string& path) {
  if (path.ends_with(".png")) return;
  throw Error(ErrorKind::invalid_argument, "a picture is written as .png", path)
      .with_field("output.path");
}

void PictureFiles::add(const std::string& path, const Picture& picture) {
  if (context_.watcher().is_cancelled()) {
    throw Error(ErrorKind::cancelled, "stopped before it was written", path);
  }
  if (on_picture_) return on_picture_(picture);
  auto file = std::make_unique<PendingFile>(local_storage(), path);
  file->append(encode_png(picture));
  file->seal();
  files_.push_back(std::move(file));
}

void PictureFiles::publish(bool overwrite) {
  std::vector<std::string> added;
  try {
    for (const auto& file : files_) {
      const bool replaces = overwrite && local_storage().exists(file->path());
      file->publish(overwrite);
      if (!replaces) added.push_back(file->path());
    }
  } catch (const Error&) {
    for (const std::string& path : added) remove_quietly(local_storage(), path);
    throw;
  }
  files_.clear();
}

}  // namespace octavo
