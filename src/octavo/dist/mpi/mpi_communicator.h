// The ranks of an MPI job, and a watch over them.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "octavo/dist/communicator.h"
#include "octavo/dist/mpi/rank_pulse.h"

namespace octavo {

/// MPI from its start to its end, of which a process has one. Whoever waits for others sleeps in
/// between: ranks may be more than cores.
class MpiJob {
 public:
  /// Throws Error{io} where MPI does not start, or not for two threads at a time.
  MpiJob();
  /// Ends MPI, with all ranks: it waits for them.
  ~MpiJob();
  MpiJob(const MpiJob&) = delete;
  MpiJob& operator=(const MpiJob&) = delete;

  /// All ranks of the job. Valid as long as this.
  Communicator& ranks();

  /// Ends all processes of the job, this one included.
  [[noreturn]] void abort(int status);

 private:
  class Ranks;
  std::unique_ptr<Ranks> ranks_;
};

struct AliveLimits {
  double silent_s = 8;   ///< without a word from a rank
  double stalled_s = 0;  ///< at work without a step; 0: no limit
};

/// While it lives, each rank tells the next one several times a second that it is there.
/// Collective: all ranks begin and end it.
class AliveWatch {
 public:
  /// pulse    of this rank; outlives the watch
  /// on_lost  gets a sentence that names the rank that is lost, and is to end the job; called once,
  ///          from a thread of the watch
  AliveWatch(MpiJob& job, const AliveLimits& limits, const RankPulse& pulse,
             std::function<void(const std::string&)> on_lost);
  ~AliveWatch();
  AliveWatch(const AliveWatch&) = delete;
  AliveWatch& operator=(const AliveWatch&) = delete;

 private:
  class Thread;
  std::unique_ptr<Thread> thread_;
};

}  // namespace octavo
