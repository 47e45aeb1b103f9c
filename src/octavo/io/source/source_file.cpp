#include "octavo/io/source/source_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/missing_path.h"
#include "octavo/io/source/natural_order.h"
#include "octavo/io/source/reader_notes.h"

namespace octavo {

namespace fs = std::filesystem;

namespace {

Error system_failure(const std::string& path, const std::string& doing) {
  const int code = errno;
  return told_missing(Error(ErrorKind::io, doing + ": " + std::strerror(code), path), code);
}

template <class Iterator>
void collect_files(const std::string& folder, std::vector<std::string>& files) {
  std::error_code failure;
  Iterator it(folder, failure);
  for (; !failure && it != Iterator(); it.increment(failure)) {
    if (it->path().filename().string().starts_with(".")) continue;
    std::error_code status_failure;
    const fs::file_status status = it->status(status_failure);
    if (status.type() == fs::file_type::not_found || status.type() == fs::file_type::none) {
      const std::string cause = "cannot examine: " + status_failure.message();
      throw Error(ErrorKind::io,
                  it->is_symlink(status_failure)
                      ? "is a link to a file that is not there; fetch that file, or remove the link"
                      : cause,
                  it->path().string());
    }
    if (fs::is_regular_file(status)) files.push_back(it->path().string());
  }
  if (failure) throw Error(ErrorKind::io, "cannot list the folder: " + failure.message(), folder);
}

/// Where all links are followed, `path` lies in `folder` or in a folder of it.
bool is_beneath(const fs::path& folder, const fs::path& path) {
  std::error_code failure;
  const fs::path root = fs::canonical(folder.empty() ? "." : folder, failure);
  if (failure) return false;
  const fs::path real = fs::canonical(path, failure);
  if (failure) return false;
  return std::mismatch(root.begin(), root.end(), real.begin(), real.end()).first == root.end();
}

}  // namespace

SourceFile::SourceFile(const std::string& path) : path_(path) {
  note_file(path);
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor_ < 0) throw system_failure(path, "cannot open");
  struct stat status {};
  const bool known = ::fstat(descriptor_, &status) == 0;
  if (!known || !S_ISREG(status.st_mode)) {
    const Error failure = known ? Error(ErrorKind::io, "is not a regular file", path)
                                : system_failure(path, "cannot examine");
    ::close(descriptor_);
    throw failure;
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

SourceFile::~SourceFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

SourceFile::SourceFile(SourceFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

std::size_t SourceFile::read_some(std::uint64_t offset, std::span<std::byte> bytes) const {
  if (offset > size_) return 0;
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::pread(descriptor_, bytes.data() + done, bytes.size() - done,
                                  static_cast<off_t>(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw system_failure(path_, "cannot read");
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  return done;
}

void SourceFile::read_exactly(std::uint64_t offset, std::span<std::byte> bytes) const {
  const std::size_t found = read_some(offset, bytes);
  if (found == bytes.size()) return;
  throw Error(ErrorKind::source_rejected,
              "the file ends early: " + std::to_string(offset + bytes.size()) +
                  " bytes expected, " + std::to_string(offset + found) +
                  " found; copy it again from its origin",
              path_, offset + found);
}

void reject(const std::string& path, const std::string& why) {
  throw Error(ErrorKind::source_rejected, why, path);
}

std::vector<std::byte> file_head(const std::string& path, std::size_t count) {
  const SourceFile file(path);
  std::vector<std::byte> head(std::min<std::uint64_t>(count, file.size()));
  head.resize(file.read_some(0, head));
  return head;
}

std::vector<std::string> files_in_folder(const std::string& folder, bool recursive) {
  std::vector<std::string> files;
  if (recursive) {
    collect_files<fs::recursive_directory_iterator>(folder, files);
  } else {
    collect_files<fs::directory_iterator>(folder, files);
  }
  std::sort(files.begin(), files.end(), natural_less);
  return files;
}

bool is_folder(const std::string& path) {
  std::error_code failure;
  return fs::is_directory(path, failure);
}

std::string base_name(const std::string& path) { return fs::path(path).filename().string(); }

std::string lower_case(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

bool has_ending(const std::string& path, const std::string& ending) {
  return lower_case(path).ends_with(ending);
}

std::string sibling_path(const std::string& header, const std::string& name) {
  const fs::path relative(name);
  const bool climbs = std::any_of(relative.begin(), relative.end(),
                                  [](const fs::path& part) { return part == ".."; });
  if (name.empty() || relative.is_absolute() || climbs) {
    throw Error(ErrorKind::source_rejected,
                "its data file \"" + escaped(name) +
                    "\" is not beneath the folder of the header; move the two together",
                header);
  }
  const fs::path folder = fs::path(header).parent_path();
  const fs::path path = folder / relative;
  std::error_code failure;
  if (!fs::exists(path, failure)) {
    throw Error(ErrorKind::source_rejected,
                "its data file \"" + escaped(name) + "\" is missing: the two belong together",
                header);
  }
  if (!is_beneath(folder, path)) {
    throw Error(ErrorKind::source_rejected,
                "its data file \"" + escaped(name) +
                    "\" is a link that leads out of the folder of the header; put the file itself "
                    "there",
                header);
  }
  if (!fs::is_regular_file(path, failure)) {
    throw Error(ErrorKind::source_rejected,
                "its data file \"" + escaped(name) + "\" is not a regular file", header);
  }
  return path.string();
}

}  // namespace octavo
