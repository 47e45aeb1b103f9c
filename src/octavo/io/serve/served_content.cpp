#include "octavo/io/serve/served_content.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"

namespace octavo {

namespace {

std::string hexadecimal_text(std::uint64_t value) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  do {
    text.insert(text.begin(), kDigits[value & 15]);
    value >>= 4;
  } while (value != 0);
  return text;
}

class MemoryBytes final : public ServedBytes {
 public:
  explicit MemoryBytes(std::vector<std::uint8_t> bytes) : bytes_(std::move(bytes)) {
    tag_ = "\"" + hexadecimal_text(bytes_.size()) + "-" + hexadecimal_text(crc32c(bytes_)) + "\"";
  }
  std::uint64_t size() const override { return bytes_.size(); }
  const std::string& entity_tag() const override { return tag_; }
  bool read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    if (offset > bytes_.size() || out.size() > bytes_.size() - offset) return false;
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
    return true;
  }

 private:
  std::vector<std::uint8_t> bytes_;
  std::string tag_;
};

class MemoryContent final : public ServedContent {
 public:
  MemoryContent(std::vector<std::uint8_t> bytes, std::string media_type)
      : bytes_(std::make_shared<MemoryBytes>(std::move(bytes))),
        media_type_(std::move(media_type)) {}
  const std::string& media_type() const override { return media_type_; }
  std::shared_ptr<const ServedBytes> now() override { return bytes_; }

 private:
  std::shared_ptr<const ServedBytes> bytes_;
  std::string media_type_;
};

/// Of what a file is known by: where it is, how long, and when it was written to last.
struct FileIdentity {
  std::uint64_t device = 0;
  std::uint64_t number = 0;
  std::uint64_t size = 0;
  std::uint64_t seconds = 0;
  std::uint64_t nanoseconds = 0;

  bool operator==(const FileIdentity&) const = default;
  std::string tag() const {
    return "\"" + hexadecimal_text(size) + "-" + hexadecimal_text(number) + "-" +
           hexadecimal_text(seconds) + "-" + hexadecimal_text(nanoseconds) + "\"";
  }
};

FileIdentity identity_of(const struct stat& state) {
#ifdef __APPLE__
  const struct timespec& written = state.st_mtimespec;
#else
  const struct timespec& written = state.st_mtim;
#endif
  return {static_cast<std::uint64_t>(state.st_dev), static_cast<std::uint64_t>(state.st_ino),
          static_cast<std::uint64_t>(state.st_size), static_cast<std::uint64_t>(written.tv_sec),
          static_cast<std::uint64_t>(written.tv_nsec)};
}

class FileBytes final : public ServedBytes {
 public:
  FileBytes(int descriptor, const FileIdentity& identity)
      : descriptor_(descriptor), identity_(identity), tag_(identity.tag()) {}
  ~FileBytes() override { ::close(descriptor_); }
  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;

  const FileIdentity& identity() const { return identity_; }
  std::uint64_t size() const override { return identity_.size; }
  const std::string& entity_tag() const override { return tag_; }
  bool read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    while (!out.empty()) {
      const ssize_t count = ::pread(descriptor_, out.data(), out.size(),
                                    static_cast<off_t>(offset));
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return false;
      offset += static_cast<std::uint64_t>(count);
      out = out.subspan(static_cast<std::size_t>(count));
    }
    // Bytes that were written meanwhile are of another file.
    struct stat state {};
    return ::fstat(descriptor_, &state) == 0 && identity_of(state) == identity_;
  }

 private:
  int descriptor_;
  FileIdentity identity_;
  std::string tag_;
};

/// Without links; as it is where nothing stands there.
std::string real_path(const std::string& path) {
  std::error_code failure;
  const std::filesystem::path real = std::filesystem::canonical(path, failure);
  return failure ? path : real.string();
}

class FileContent final : public ServedContent {
 public:
  FileContent(const std::string& path, std::string media_type)
      : path_(real_path(path)), media_type_(std::move(media_type)) {
    bytes_ = opened();
    if (!bytes_) {
      const int reason = errno;
      throw Error(ErrorKind::io,
                  reason == 0 ? "is no file"
                              : "cannot be read: " + std::generic_category().message(reason),
                  path);
    }
  }
  const std::string& media_type() const override { return media_type_; }
  std::shared_ptr<const ServedBytes> now() override {
    struct stat state {};
    const bool is_there = ::stat(path_.c_str(), &state) == 0;
    if (!is_there || !bytes_ || identity_of(state) != bytes_->identity()) bytes_ = opened();
    return bytes_;
  }

 private:
  /// Null, with the reason in errno (0: no file), where that fails.
  std::shared_ptr<const FileBytes> opened() const {
    // A pipe or a device would wait, or never end.
    const int descriptor = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW);
    if (descriptor < 0) return nullptr;
    struct stat state {};
    const bool is_file = ::fstat(descriptor, &state) == 0 && S_ISREG(state.st_mode);
    if (!is_file || real_path(path_) != path_) {
      ::close(descriptor);
      errno = 0;
      return nullptr;
    }
    return std::make_shared<FileBytes>(descriptor, identity_of(state));
  }

  std::string path_;  // the real one
  std::string media_type_;
  std::shared_ptr<const FileBytes> bytes_;
};

struct MediaType {
  const char* ending;
  const char* type;
};

constexpr MediaType kMediaTypes[] = {
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".json", "application/json"},
    {".wasm", "application/wasm"},
    {".png", "image/png"},
    {".md", "text/markdown; charset=utf-8"},
    {".8vo", "application/vnd.octavo"},
};

}  // namespace

std::shared_ptr<const ServedBytes> memory_bytes(std::vector<std::uint8_t> bytes) {
  return std::make_shared<MemoryBytes>(std::move(bytes));
}

std::unique_ptr<ServedContent> memory_content(std::vector<std::uint8_t> bytes,
                                              std::string media_type) {
  return std::make_unique<MemoryContent>(std::move(bytes), std::move(media_type));
}

std::unique_ptr<ServedContent> file_content(const std::string& path, std::string media_type) {
  return std::make_unique<FileContent>(path, std::move(media_type));
}

std::string media_type_of(const std::string& name) {
  for (const MediaType& row : kMediaTypes) {
    if (name.ends_with(row.ending)) return row.type;
  }
  return "application/octet-stream";
}

}  // namespace octavo
