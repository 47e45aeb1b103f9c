// What a server gives out: files of the disk, and pages that are kept in memory.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace octavo {

/// The bytes of one answer. They do not change while it lives.
class ServedBytes {
 public:
  virtual ~ServedBytes() = default;
  virtual std::uint64_t size() const = 0;
  /// In quotes; another one for other bytes.
  virtual const std::string& entity_tag() const = 0;
  /// Fills `out` with the bytes from `offset` on.
  /// Returns whether all of it could be read
  virtual bool read(std::uint64_t offset, std::span<std::uint8_t> out) const = 0;
};

/// A file in what stands at an address.
struct ServedPart {
  std::string media_type;
  std::shared_ptr<const ServedBytes> bytes;  ///< null where they cannot be read
};

/// What stands at one address of a site.
class ServedContent {
 public:
  virtual ~ServedContent() = default;
  /// What stands behind an address that ends in "/"; nothing where nothing does. Called by several
  /// threads at once.
  virtual std::optional<ServedPart> beneath(std::string_view /*key*/) { return std::nullopt; }
  virtual const std::string& media_type() const = 0;
  /// The bytes that stand there now; null where they cannot be read.
  virtual std::shared_ptr<const ServedBytes> now() = 0;
};

/// Bytes in memory; their tag is their checksum.
std::shared_ptr<const ServedBytes> memory_bytes(std::vector<std::uint8_t> bytes);

/// Bytes in memory.
std::unique_ptr<ServedContent> memory_content(std::vector<std::uint8_t> bytes,
                                              std::string media_type);

/// A file of the disk, which is opened again once another one has taken its name or it was written
/// to. An answer that has begun goes on with the file that it began with. Links in `path` are
/// followed once, now: what becomes a link later, or lies behind one, cannot be read, so that who
/// may write into a folder gives out nothing from elsewhere.
/// Throws Error{io} when it cannot be opened or is no file
std::unique_ptr<ServedContent> file_content(const std::string& path, std::string media_type);

/// "text/html; charset=utf-8" for "index.html", by the ending of a name.
std::string media_type_of(const std::string& name);

}  // namespace octavo
