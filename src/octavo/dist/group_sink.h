// The groups of one rank, each encoded in memory until its place in the file is known.
//
//   TierEncoder --bricks--> GroupSink --take--> EncodedGroup: level 0 | other streams | what a
//                                               journal holds of it
//
// Memory is that of two encoded groups: one that waits for its place, one that is being encoded.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "octavo/core/levels.h"
#include "octavo/file/layout.h"
#include "octavo/file/write/append_file.h"
#include "octavo/file/write/brick_sink.h"
#include "octavo/file/write/run_writer.h"
#include "octavo/file/write/spool.h"

namespace octavo {

struct EncodedGroup {
  JournalGroup group;          ///< as if the group were a run of its own: offsets from a header on
  std::vector<Bytes> level_0;  ///< block by block
  std::unique_ptr<Spool> streams;      ///< those of a run behind level 0
  std::vector<double> squared_errors;  ///< of its bricks, where details are left out

  std::uint64_t level_0_bytes() const { return group.file_bytes - kHeaderBytes; }
};

class GroupSink final : public BrickSink {
 public:
  /// Both must outlive the sink.
  GroupSink(const FileHeader& header, const Levels& levels) : header_(header), levels_(levels) {}

  /// Announces the next group, before its first brick.
  void expect(const RunStart& start);

  /// The oldest group that is whole, when one is or becomes so within the time.
  std::optional<EncodedGroup> take(std::chrono::milliseconds time);

  void add_model(const Bytes& model) override;
  void add_brick(int tier, const EncodedBrick& brick) override;
  void add_plane_digests(std::span<const Sha256Digest> digests) override;
  void end_group(std::uint32_t voxels_crc) override;

 private:
  /// The group that bricks come for.
  struct Growing {
    AppendFile out;
    std::unique_ptr<Spool> streams;
    std::optional<RunWriter> run;
    std::vector<double> squared_errors;
  };

  const FileHeader& header_;
  const Levels& levels_;
  std::unique_ptr<Growing> growing_;

  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::deque<RunStart> expected_;
  std::deque<EncodedGroup> whole_;
};

}  // namespace octavo
