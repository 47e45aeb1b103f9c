// Reads the planes of one group ahead, on a thread of its own.
//
// A group is the fewest brick layers whose voxels reach 32 MiB. Two group buffers exist: one is
// being encoded while the other is filled.
#pragma once

#include <atomic>
#include <cstddef>
#include <future>
#include <vector>

#include "octavo/build/float_planes.h"
#include "octavo/build/plane_source.h"
#include "octavo/build/voxel_block.h"
#include "octavo/core/progress.h"

namespace octavo {

inline constexpr std::uint64_t kGroupBytes = std::uint64_t{32} << 20;

/// Planes of a group of `levels`: whole layers, at most the volume's planes.
std::int64_t group_planes(const Levels& levels, VoxelType type);

class GroupReader {
 public:
  /// All must outlive the reader. Starts to read the first group.
  /// floats  the source itself when blocks shall hold the float voxels beside their codes
  GroupReader(PlaneSource& source, const Levels& levels, Progress& progress,
              const FloatPlanes* floats = nullptr);

  /// Stops at the next plane and joins the reading thread.
  ~GroupReader();

  GroupReader(const GroupReader&) = delete;
  GroupReader& operator=(const GroupReader&) = delete;

  /// True when all groups were taken.
  bool is_done() const { return next_plane_ == size_.z; }

  /// Waits for the next group and starts to read the one after it. The block stays valid until the
  /// next call.
  /// Throws what the source throws; Error{cancelled}. Requires that is_done() is false.
  VoxelBlock next();

  /// Time spent in the source so far.
  double read_seconds() const { return read_seconds_; }

 private:
  void start(std::int64_t first_plane);
  void read(std::int64_t first_plane, std::int64_t end);

  /// Planes of a group: as the bricks hold them, and as floats where those differ.
  struct Buffer {
    std::vector<std::byte> voxels;
    std::vector<float> floats;
  };

  PlaneSource& source_;
  Progress& progress_;
  const FloatPlanes* floats_;
  Size3 size_;
  VoxelType type_;
  std::int64_t planes_per_group_;
  std::int64_t next_plane_ = 0;  // first plane of the group that next() gives
  Buffer taken_;
  Buffer filling_;
  std::atomic<bool> is_stopped_ = false;
  double read_seconds_ = 0;  // written by the reading thread, read after it was waited for
  std::future<void> reading_;
};

}  // namespace octavo
