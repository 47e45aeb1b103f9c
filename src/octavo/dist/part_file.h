// A file that holds some groups of a build, encoded, or a band of one.
//
//   head     512 bytes: magic 8f '8prt' 0d 0a 1a, u32 version, u64 plan, u64 first group,
//            u64 end group, u64 offset of the tail, u64 its length, u32 its CRC; of a band u64
//            first brick, u64 end brick; at byte 508 the CRC of the bytes before
//   streams  those of a run or a band (run_writer.h), one behind the other, level 0 first
//   tail     length and CRC of each stream; the groups as in a journal, and the squared errors of
//            their bricks where details are left out; floats that only level 0 holds
//
// Invariants
//   A part depends on the plan and on the planes of its groups; made twice it has the same bytes.
//   Its name holds a whole part or none.
// Consequences
//   Nobody who writes a part needs a lock, and who finds a part that fits the plan can keep it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "octavo/builder/exact_coding.h"
#include "octavo/core/levels.h"
#include "octavo/core/progress.h"
#include "octavo/dist/part_place.h"
#include "octavo/file/layout.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/write/append_file.h"
#include "octavo/file/write/brick_sink.h"
#include "octavo/file/write/encoded_run.h"
#include "octavo/file/write/run_writer.h"
#include "octavo/file/write/spool.h"

namespace octavo {

inline constexpr std::uint32_t kPartVersion = 3;
inline constexpr std::uint32_t kBandVersion = 4;  ///< of parts that hold a band

/// Writes the bricks of a part. Destroyed before finish() it leaves nothing.
class PartWriter final : public BrickSink {
 public:
  /// start  the first layer and, as its model, the first group; of a band its bricks
  /// Throws Error{io}
  PartWriter(Storage& storage, std::string path, const FileHeader& header, const Levels& levels,
             const PartPlace& place, const RunStart& start);
  ~PartWriter() override;

  void add_model(const Bytes& model) override { run_->add_model(model); }
  void add_brick(int tier, const EncodedBrick& brick) override;
  void add_plane_digests(std::span<const Sha256Digest> digests) override {
    run_->add_plane_digests(digests);
  }
  void end_group(std::uint32_t voxels_crc) override;

  /// Ends a band, in place of a group.
  /// digests  of its hashed_planes
  void end_band(std::uint32_t voxels_crc, std::vector<Sha256Digest> digests);

  void set_clipped(const ClippedVoxels& clipped) { clipped_ = clipped; }

  /// Writes the rest, syncs, and gives the file its name in place of whatever has it.
  void finish();

 private:
  Bytes tail() const;

  Storage& storage_;
  std::string path_;
  FileHeader header_;
  Levels levels_;
  PartPlace place_;
  std::string temporary_;
  std::unique_ptr<AppendFile> out_;
  Spool spool_;
  std::unique_ptr<RunWriter> run_;
  std::vector<JournalGroup> groups_;
  std::vector<std::vector<double>> errors_;  ///< of the bricks of each group, and of the next one
  std::vector<Section> streams_;
  ClippedVoxels clipped_;
};

/// A part that is read. Its streams are proven as they are copied. Between two calls the file is
/// not open: there may be more parts than a process can have open files.
class PartFile final : public EncodedRun {
 public:
  /// Throws  Error{not_octavo} for what is no part, Error{unsupported_version}, Error{corrupt},
  ///         Error{truncated}, Error{io}
  static std::unique_ptr<PartFile> open(Storage& storage, const std::string& path);

  const std::string& path() const { return path_; }
  const PartPlace& place() const { return place_; }
  const ClippedVoxels& clipped() const { return clipped_; }

  /// Proves that its groups, or the bricks of its band, are those of a volume of these levels, from
  /// `first_layer` on.
  /// Throws Error{corrupt}
  void require_groups(const Levels& levels, std::int64_t first_layer) const;

  /// Adds the squared errors of its bricks, one by one, to those of all bricks before; its groups
  /// then hold sums as those of a whole build. Returns the sum.
  double add_errors(double before);

  /// From now on copies advance `progress`, which outlives them, by their bytes, and end with
  /// Error{cancelled} when it says so. Null: nobody watches.
  void watch(Progress* progress) { progress_ = progress; }

  /// Proves every byte of its streams. Throws as copy
  void prove() const;

  std::size_t stream_count() const { return streams_.size(); }

  /// Whether the file of a join holds a stream as it is: the pages of a band become others.
  bool is_joined(std::size_t stream) const {
    return !place_.is_band() || stream + 1 < streams_.size();
  }
  /// Of all streams.
  std::uint64_t stream_bytes() const;
  /// Of those that the file of a join holds as they are.
  std::uint64_t joined_bytes() const;

  const std::vector<JournalGroup>& groups() const override { return groups_; }
  Section stream(std::size_t number) const override { return streams_.at(number); }
  void read(std::size_t stream, std::uint64_t offset,
            std::span<std::uint8_t> out) const override;
  void copy(std::size_t stream, const std::function<void(ByteSpan)>& sink) const override;

 private:
  PartFile(Storage& storage, std::string path) : storage_(storage), path_(std::move(path)) {}
  void read_tail(ByteSpan bytes, std::uint64_t tail_offset);
  bool is_band_of(const Levels& levels, std::int64_t layer) const;
  [[noreturn]] void fail(const std::string& what) const;

  Storage& storage_;
  std::string path_;
  Progress* progress_ = nullptr;
  PartPlace place_;
  std::vector<Section> streams_;
  std::vector<JournalGroup> groups_;
  std::vector<std::vector<double>> errors_;
  ClippedVoxels clipped_;
};

/// Has parts watched while it lives.
class WatchedParts {
 public:
  WatchedParts(const std::vector<std::shared_ptr<PartFile>>& parts, Progress& progress)
      : parts_(parts) {
    for (const auto& part : parts_) part->watch(&progress);
  }
  ~WatchedParts() {
    for (const auto& part : parts_) part->watch(nullptr);
  }
  WatchedParts(const WatchedParts&) = delete;
  WatchedParts& operator=(const WatchedParts&) = delete;

 private:
  std::vector<std::shared_ptr<PartFile>> parts_;
};

}  // namespace octavo
