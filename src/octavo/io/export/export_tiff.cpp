#include <cerrno>
#include <filesystem>
#include <optional>
#include <system_error>

#include "octavo/core/path_text.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/file/storage/plane_folder.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/io/export/export_target.h"
#include "octavo/io/export/tiff_output.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

namespace fs = std::filesystem;

/// Above this many voxel bytes a file is a BigTIFF: even expanded by deflate it stays below 2^32
/// otherwise.
constexpr std::uint64_t kBigTiffBytes = 4'000'000'000;

/// Calls `take(plane)` for each of the planes.
template <class F>
void for_each_plane(const ExportPlan& plan, std::span<const std::uint8_t> planes, F&& take) {
  const auto step = static_cast<std::size_t>(plan.plane_bytes());
  for (std::size_t at = 0; at < planes.size(); at += step) take(planes.subspan(at, step));
}

class TiffPagesTarget final : public ExportTarget {
 public:
  TiffPagesTarget(Storage& storage, const std::string& path, const ExportPlan& plan) : plan_(plan) {
    require_free(storage, path, plan.overwrite);
    file_ = std::make_unique<PendingFile>(storage, path);
    tiff_.emplace(file_->file(), plan.voxel_bytes() > kBigTiffBytes);
  }

  void write_planes(std::span<const std::uint8_t> planes) override {
    for_each_plane(plan_, planes, [&](std::span<const std::uint8_t> plane) {
      tiff_->add_page(plan_, deflate_page(plan_, plane),
                      is_first_ ? tiff_description(plan_, plan_.size.z) : std::string());
      is_first_ = false;
    });
  }

  std::vector<std::string> finish() override {
    tiff_->finish();
    file_->seal();
    file_->publish(plan_.overwrite);
    return {file_->path()};
  }

  std::uint64_t bytes() const override { return file_->size(); }

 private:
  ExportPlan plan_;
  bool is_first_ = true;
  std::unique_ptr<PendingFile> file_;
  std::optional<TiffOutput> tiff_;
};

/// Proves that `folder` may become the stack: it is absent or empty, or may be replaced and holds
/// planes of an earlier stack and nothing else. Returns one of these planes, or nothing.
std::string check_folder(Storage& storage, const std::string& folder, bool overwrite) {
  if (!storage.exists(folder)) return {};
  if (!is_folder(folder)) {
    throw Error(ErrorKind::io, "is a file; a TIFF stack needs a folder", folder);
  }
  PlaneList list;
  if (!list_planes(folder, list)) {
    throw Error(ErrorKind::io,
                "cannot list the folder: " + std::generic_category().message(errno), folder);
  }
  if (!overwrite && (!list.planes.empty() || !list.other.empty())) {
    throw Error(ErrorKind::io, "the folder is not empty; an earlier stack alone can be replaced",
                folder)
        .with_field("overwrite");
  }
  if (!list.other.empty()) {
    throw Error(ErrorKind::io,
                "the folder holds " + escaped(list.other) +
                    ", which is no plane of a stack; it is not replaced, name another folder",
                folder);
  }
  return list.planes.empty() ? std::string() : folder + "/" + list.planes.back();
}

/// The stack grows in a folder beside its own, which takes the name when all planes are on disk.
class TiffFolderTarget final : public ExportTarget {
 public:
  TiffFolderTarget(Storage& storage, std::string folder, const ExportPlan& plan)
      : storage_(storage), plan_(plan), folder_(std::move(folder)) {
    settle_earlier();
    earlier_plane_ = check_folder(storage_, folder_, plan_.overwrite);
    try {
      TemporaryFile temporary = create_temporary_folder(storage, folder_);
      temporary_ = std::move(temporary.path);
      lock_ = std::move(temporary.file);
    } catch (const Error& error) {
      throw with_final_name(error, folder_);
    }
  }

  ~TiffFolderTarget() override {
    std::error_code ignored;
    if (!is_published_) fs::remove_all(temporary_, ignored);
  }

  void write_planes(std::span<const std::uint8_t> planes) override {
    for_each_plane(plan_, planes, [&](std::span<const std::uint8_t> plane) { write_file(plane); });
  }

  std::vector<std::string> finish() override {
    storage_.sync_folder(temporary_);
    if (!check_folder(storage_, folder_, plan_.overwrite).empty()) {
      replace_earlier();
    } else {
      storage_.rename(temporary_, folder_);
      is_published_ = true;
      sync_new_name(storage_, folder_);
    }
    std::vector<std::string> files;
    for (std::int64_t z = 0; z < plan_.size.z; ++z) {
      files.push_back(folder_ + "/" + plane_name(z, plan_.size.z));
    }
    return files;
  }

  std::uint64_t bytes() const override { return bytes_; }

 private:
  void write_file(std::span<const std::uint8_t> plane) {
    ExportPlan page = plan_;
    page.geometry = cropped(plan_.geometry, {0, 0, next_plane_});
    const auto file = storage_.create_replacement(
        temporary_ + "/" + plane_name(next_plane_++, plan_.size.z), earlier_plane_);
    TiffOutput tiff(*file, plan_.plane_bytes() > kBigTiffBytes);
    tiff.add_page(page, deflate_page(page, plane), tiff_description(page, 1));
    tiff.finish();
    bytes_ += file->size();
    file->sync();
    file->close();
  }

  // The earlier stack ends up under the temporary name, or that of two steps, and goes when the new
  // one is on disk.
  void replace_earlier() {
    std::string earlier = temporary_;
    if (!storage_.exchange(temporary_, folder_)) {
      earlier = earlier_name(folder_);
      replace_in_two_steps(earlier);
    }
    is_published_ = true;
    sync_new_name(storage_, folder_);
    remove_earlier(earlier);
  }

  // For file systems without an exchange.
  void replace_in_two_steps(const std::string& earlier) {
    storage_.rename_new(folder_, earlier);
    try {
      storage_.rename(temporary_, folder_);
    } catch (...) {
      storage_.rename(earlier, folder_);
      throw;
    }
  }

  // Ends what an export left that was killed between the two steps, or behind them.
  void settle_earlier() {
    const std::string earlier = earlier_name(folder_);
    if (!storage_.exists(earlier)) return;
    if (storage_.exists(folder_)) return remove_earlier(earlier);
    storage_.rename_new(earlier, folder_);
    sync_new_name(storage_, folder_);
  }

  // What cannot be removed is reported, and by every later export until it is.
  void remove_earlier(const std::string& earlier) const {
    if (remove_plane_folder(earlier) || errno == ENOENT) return;
    const int reason = errno;
    throw Error(ErrorKind::io,
                "the earlier stack of this name, " + escaped(base_name_of(kept_name(earlier))) +
                    ", cannot be removed: " + std::generic_category().message(reason),
                folder_);
  }

  // Calls an earlier stack by its name of two steps, where that is free; returns its name.
  std::string kept_name(const std::string& earlier) const {
    if (earlier == earlier_name(folder_)) return earlier;
    try {
      storage_.rename_new(earlier, earlier_name(folder_));
      return earlier_name(folder_);
    } catch (const Error&) {
      return earlier;
    }
  }

  Storage& storage_;
  ExportPlan plan_;
  std::string folder_;
  std::string earlier_plane_;  ///< whose permissions the planes get; empty without one
  std::string temporary_;
  std::unique_ptr<StorageFile> lock_;  ///< says that `temporary_` is not left behind
  std::int64_t next_plane_ = 0;
  std::uint64_t bytes_ = 0;
  bool is_published_ = false;
};

bool is_one_file(const std::string& path) {
  return !path.ends_with('/') && !is_folder(path) &&
         (has_ending(path, ".tif") || has_ending(path, ".tiff"));
}

}  // namespace

std::string resolved_stack_path(const std::string& path) {
  const std::string folder = without_end_slashes(path);
  std::error_code failure;
  if (is_one_file(path) || !fs::is_symlink(folder, failure)) return path;
  const std::string target = fs::canonical(folder, failure).string();
  if (failure) {
    throw Error(ErrorKind::io, "is a link that cannot be followed: " + failure.message(), folder);
  }
  return target + "/";
}

std::unique_ptr<ExportTarget> make_tiff_target(Storage& storage, const std::string& path,
                                               const ExportPlan& plan) {
  if (is_one_file(path)) return std::make_unique<TiffPagesTarget>(storage, path, plan);
  return std::make_unique<TiffFolderTarget>(storage, without_end_slashes(path), plan);
}

}  // namespace octavo
