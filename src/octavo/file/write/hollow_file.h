// A growing file in which runs are left out, to be copied to their places by somebody else.
#pragma once

#include <map>
#include <memory>
#include <utility>

#include "octavo/file/storage/storage.h"
#include "octavo/file/write/encoded_run.h"

namespace octavo {

/// What is read where a run belongs comes from the run; all else is that of `file`.
class HollowFile final : public StorageFile {
 public:
  explicit HollowFile(std::unique_ptr<StorageFile> file) : file_(std::move(file)) {}

  /// Bytes from `offset` on are those of a stream that stand in a file (EncodedRun::stored_bytes).
  /// The run outlives the file.
  void leave_out(std::uint64_t offset, const EncodedRun& run, std::size_t stream);

  const std::string& path() const override { return file_->path(); }
  std::uint64_t size() const override { return file_->size(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override;
  void write(std::uint64_t offset, std::span<const std::uint8_t> bytes) override {
    file_->write(offset, bytes);
  }
  void truncate(std::uint64_t size) override { file_->truncate(size); }
  void sync() override { file_->sync(); }
  void close() override { file_->close(); }

 private:
  struct LeftOut {
    const EncodedRun* run;
    std::size_t stream;
    std::uint64_t length;
  };

  std::unique_ptr<StorageFile> file_;
  std::map<std::uint64_t, LeftOut> left_out_;  ///< by offset; apart from one another
};

}  // namespace octavo
