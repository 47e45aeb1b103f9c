// Where the files of a zarr hierarchy go: a folder, or one zip file of them (.ozx, RFC-9 of
// OME-Zarr). Either has its name when it is complete.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "octavo/file/storage/storage.h"

namespace octavo {

/// Takes files one after another; one that is destroyed before finish() leaves nothing behind.
class ZarrOutput {
 public:
  virtual ~ZarrOutput() = default;
  /// key  "0/c/1/2/3": names with slashes between
  /// Throws Error{io}
  virtual void put(const std::string& key, std::span<const std::uint8_t> bytes) = 0;
  /// Gives the whole its name. Throws Error{io}
  virtual void finish() = 0;
  /// Of all files so far.
  virtual std::uint64_t bytes() const = 0;
};

/// A folder, named without a slash behind it. One that stands there is replaced only where it holds
/// zarr.json, and nothing but what is written here. What killed processes left for the same name
/// goes first.
/// Throws Error{io} where the name is taken and may not be replaced
std::unique_ptr<ZarrOutput> make_zarr_folder(Storage& storage, const std::string& path,
                                             bool overwrite);

/// A zip file without compression, of any size. Throws as make_zarr_folder
std::unique_ptr<ZarrOutput> make_zarr_zip(Storage& storage, const std::string& path,
                                          bool overwrite);

}  // namespace octavo
