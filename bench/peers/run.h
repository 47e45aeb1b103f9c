// One run of one codec on one volume, in a process of its own.
#pragma once

#include <cstdint>

#include "bench/peers/peer.h"

namespace octavo::bench {

/// One direction of a run.
struct Effort {
  double seconds = 0;
  /// Growth of resident memory above what the process had before: the codec's own need and, when
  /// encoding, its result. 0 where the system does not tell.
  std::uint64_t peak_memory_bytes = 0;
};

struct RunResult {
  Effort encode;
  Effort decode;
  std::uint64_t byte_count = 0;
  std::int64_t measured_error = 0;  ///< largest |decoded - source|, voxel units
  double psnr_db = 0;               ///< infinite when lossless
};

/// Encodes and decodes `volume` once in a forked child and compares the voxels there.
/// Requires that this process has no other thread.
/// Throws Error{internal} when the child fails or a voxel is off by more than `max_error`; the
///        child has said on stderr why.
RunResult run_in_child(Peer& peer, const RawVolume& volume, std::int64_t max_error);

}  // namespace octavo::bench
