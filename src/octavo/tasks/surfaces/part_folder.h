// A folder that gets several files, or none of them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "octavo/file/storage/pending_file.h"

namespace octavo {

/// The files grow in a hidden folder: beside the one that is asked for, whose name it takes in one
/// step, or within it where it is there already. There the files take their names one by one, those
/// that they replace come back if one fails, and what a killed process leaves is of whole files.
/// Destroyed before `publish` it leaves nothing. Hidden folders that killed processes left are
/// removed first.
/// Every call throws Error{io} that names a file as it will be called.
class PartFolder {
 public:
  /// overwrite  files of the same names are replaced
  /// Throws  where the name is one of a file, and where the folder around it is missing or takes no
  ///         files
  PartFolder(Storage& storage, std::string path, bool overwrite);
  ~PartFolder();
  PartFolder(const PartFolder&) = delete;
  PartFolder& operator=(const PartFolder&) = delete;

  /// What a file will be called.
  std::string file(const std::string& name) const { return path_ + "/" + name; }
  /// Proves that a name may be used.
  void require_free(const std::string& name) const;

  /// A new file, which `write` fills.
  /// Returns its size
  std::uint64_t add(const std::string& name, const std::function<void(PendingFile&)>& write);

  /// Removes a file that was added, so that it may be added again; nothing where there is none.
  void take_back(const std::string& name);

  /// The bytes of a file that was added.
  std::shared_ptr<const ByteSource> open(const std::string& name) const;

  /// Gives all files their names, durably.
  void publish();

 private:
  /// A file that stands under its name, and what it replaced.
  struct Placed {
    std::string name;
    std::string earlier;  // where that stands; empty: there was none
  };

  std::string hidden(const std::string& name) const { return hidden_ + "/" + name; }
  template <class F>
  auto named(F f) const;
  void begin();
  bool is_part_file(const std::string& path) const;
  void remove_left(const std::string& left) const;
  void place(const std::string& name);
  void put_back() noexcept;
  void remove_hidden() noexcept;

  Storage& storage_;
  std::string path_;
  bool overwrite_;
  bool is_new_ = false;  // the folder is not there yet
  std::string hidden_;   // empty before the first file
  std::unique_ptr<StorageFile> lock_;
  std::vector<std::string> names_;
  std::vector<Placed> placed_;
};

}  // namespace octavo
