// Reads the planes of one group ahead, on a thread of its own.
//
// A group is the fewest brick layers whose voxels reach 32 MiB. Two group buffers exist: while one
// is being encoded the other is filled and trained on; the next group is read as soon as one of
// them is free, whoever waits.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "octavo/builder/float_planes.h"
#include "octavo/builder/voxel_block.h"
#include "octavo/builder/workers.h"
#include "octavo/core/progress.h"
#include "octavo/core/unset_bytes.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

inline constexpr std::uint64_t kGroupBytes = std::uint64_t{32} << 20;

/// While it lives, groups hold so many bytes instead: for tests of many groups, whose files are
/// those of no other program.
class SmallGroups {
 public:
  explicit SmallGroups(std::uint64_t bytes);
  ~SmallGroups();
  SmallGroups(const SmallGroups&) = delete;
  SmallGroups& operator=(const SmallGroups&) = delete;
};

/// Planes of a group of `levels`: whole layers, at most the volume's planes.
std::int64_t group_planes(const Levels& levels, VoxelType type);

class GroupReader {
 public:
  /// All must outlive the reader. Starts to read the first group.
  /// floats  the source itself when blocks shall hold the float voxels beside their codes
  GroupReader(PlaneSource& source, const Levels& levels, Progress& progress,
              const FloatPlanes* floats = nullptr);

  /// The same of some groups: those from plane `first` up to `end`, where groups begin. The source
  /// is sought there.
  /// step  1: all of them; n: each n-th one, beginning with the first
  GroupReader(PlaneSource& source, const Levels& levels, Progress& progress,
              const FloatPlanes* floats, std::int64_t first, std::int64_t end,
              std::int64_t step = 1);

  /// Stops at the next plane and joins the reading thread.
  ~GroupReader();

  GroupReader(const GroupReader&) = delete;
  GroupReader& operator=(const GroupReader&) = delete;

  /// True when all groups were taken.
  bool is_done() const { return next_plane_ >= end_plane_; }

  /// Waits for the next group. The block stays valid until it is released.
  /// Two blocks may be out at a time: it waits for one of them to be released as well, and helps
  /// `workers` meanwhile.
  /// Throws what the source throws; Error{cancelled}. Requires that is_done() is false.
  VoxelBlock next(Workers& workers);

  /// Gives back the oldest block, so that another group can be read in its place. From any thread.
  void release();

  /// Time spent in the source. Requires is_done().
  double read_seconds() const { return read_seconds_; }

 private:
  /// Planes of a group: as the bricks hold them, and as floats where those differ.
  struct Buffer {
    UnsetBytes voxels;
    std::vector<float> floats;
    std::uint32_t crc = 0;
  };

  GroupReader(PlaneSource& source, const Levels& levels, Progress& progress,
              const FloatPlanes* floats, std::int64_t first, std::int64_t end, std::int64_t step,
              bool seeks);

  void read_groups();
  bool wait_for_room(std::size_t group);
  std::int64_t end_of_group(std::int64_t first) const;
  void fill(Buffer& buffer, std::int64_t planes);

  PlaneSource& source_;
  Progress& progress_;
  const FloatPlanes* floats_;
  Size3 size_;
  VoxelType type_;
  std::int64_t planes_per_group_;
  std::int64_t step_planes_;  // from the start of a group to that of the next one
  bool seeks_;               // whether the source may stand elsewhere
  std::int64_t first_plane_;
  std::int64_t next_plane_;  // first plane of the group that next() gives
  std::int64_t end_plane_;
  std::size_t taken_ = 0;        // groups that next() gave
  std::array<Buffer, 2> buffers_;
  std::atomic<bool> is_stopped_ = false;
  double read_seconds_ = 0;  // written by the reading thread before it notes a group as read

  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t read_ = 0;      // groups in buffers or past, guarded by mutex_
  std::size_t released_ = 0;  // guarded by mutex_
  std::exception_ptr failure_;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace octavo
