// How the ranks of a job, alike processes with numbers, speak to one another.
//
// An interface: MPI is one that runs on many machines (dist/mpi), threads of one process are
// another (thread_ranks.h). All ranks call the collective ones in the same order, each from one
// thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/bytes.h"

namespace octavo {

/// Of numbers that every rank has, place by place.
struct RankSums {
  std::vector<std::uint64_t> before;  ///< over the ranks of lower numbers
  std::vector<std::uint64_t> all;
};

class Communicator {
 public:
  virtual ~Communicator() = default;

  /// 0 <= rank < size.
  virtual int rank() const = 0;
  virtual int size() const = 0;

  /// Messages from one rank to another arrive in their order; `send` may wait for `receive`.
  /// Throws Error{io} that names the other rank; Error{cancelled} where the job ends meanwhile
  virtual void send(int to, ByteSpan bytes) = 0;
  virtual Bytes receive(int from) = 0;

  /// Collective. By default of messages by way of rank 0. They throw as `send`.
  virtual RankSums sum_before(std::span<const std::uint64_t> values);
  /// What rank 0 gives, to all; the others' bytes mean nothing.
  virtual Bytes broadcast(ByteSpan bytes);
  /// Returns when all have called it.
  virtual void barrier();

  /// Collective: what each rank gives, at rank 0 by their numbers; nothing at the others.
  std::vector<Bytes> collect(ByteSpan bytes);

  /// Collective: what each rank has for each other one, and gets of each, by their numbers.
  /// outgoing  one for each rank
  std::vector<Bytes> exchange(std::vector<Bytes> outgoing);

  bool is_first() const { return rank() == 0; }
};

}  // namespace octavo
