#include "octavo/dist/mpi/mpi_communicator.h"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "octavo/core/error.h"
#include "octavo/file/byte_codec.h"

namespace octavo {

namespace {

constexpr int kMessageTag = 1;
// MPI counts bytes in an int.
constexpr std::size_t kMostBytes = std::size_t{1} << 30;

// Short waits are the rule while ranks keep in step; long ones are for the slowest.
constexpr std::chrono::microseconds kShortestNap{50};
constexpr std::chrono::microseconds kLongestNap{5000};

void require_success(int code, const std::string& what) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING] = "";
  int length = 0;
  MPI_Error_string(code, text, &length);
  throw Error(ErrorKind::io, what + ": " + text);
}

void wait_for(MPI_Request& request, const std::string& what) {
  auto nap = kShortestNap;
  for (;;) {
    int is_done = 0;
    require_success(MPI_Test(&request, &is_done, MPI_STATUS_IGNORE), what);
    if (is_done != 0) return;
    std::this_thread::sleep_for(nap);
    nap = std::min(2 * nap, kLongestNap);
  }
}

std::string rank_text(int rank) { return "rank " + std::to_string(rank); }

/// Calls `move(bytes, count)` for pieces that MPI can count.
template <class Byte, class F>
void in_pieces(Byte* bytes, std::size_t count, const F& move) {
  for (std::size_t at = 0; at < count; at += kMostBytes) {
    move(bytes + at, static_cast<int>(std::min(kMostBytes, count - at)));
  }
}

}  // namespace

class MpiJob::Ranks final : public Communicator {
 public:
  Ranks() {
    MPI_Comm_dup(MPI_COMM_WORLD, &all_);
    MPI_Comm_set_errhandler(all_, MPI_ERRORS_RETURN);
    MPI_Comm_rank(all_, &rank_);
    MPI_Comm_size(all_, &size_);
  }
  ~Ranks() override { MPI_Comm_free(&all_); }
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  int rank() const override { return rank_; }
  int size() const override { return size_; }

  void send(int to, ByteSpan bytes) override {
    const std::string what = "cannot send to " + rank_text(to);
    const std::uint64_t count = bytes.size();
    const auto move = [&](const void* data, int length, MPI_Datatype type) {
      MPI_Request request;
      require_success(MPI_Isend(data, length, type, to, kMessageTag, all_, &request), what);
      wait_for(request, what);
    };
    move(&count, 1, MPI_UINT64_T);
    in_pieces(bytes.data(), bytes.size(),
              [&](const std::uint8_t* piece, int length) { move(piece, length, MPI_BYTE); });
  }

  Bytes receive(int from) override {
    const std::string what = "cannot hear " + rank_text(from);
    const auto move = [&](void* data, int length, MPI_Datatype type) {
      MPI_Request request;
      require_success(MPI_Irecv(data, length, type, from, kMessageTag, all_, &request), what);
      wait_for(request, what);
    };
    std::uint64_t count = 0;
    move(&count, 1, MPI_UINT64_T);
    Bytes bytes(static_cast<std::size_t>(count));
    in_pieces(bytes.data(), bytes.size(),
              [&](std::uint8_t* piece, int length) { move(piece, length, MPI_BYTE); });
    return bytes;
  }

  RankSums sum_before(std::span<const std::uint64_t> values) override {
    const std::string what = "cannot sum up over the ranks";
    RankSums sums{std::vector<std::uint64_t>(values.size()),
                  std::vector<std::uint64_t>(values.size())};
    const auto count = static_cast<int>(values.size());
    MPI_Request request;
    require_success(MPI_Iexscan(values.data(), sums.before.data(), count, MPI_UINT64_T, MPI_SUM,
                                all_, &request),
                    what);
    wait_for(request, what);
    if (is_first()) std::ranges::fill(sums.before, std::uint64_t{0});
    require_success(MPI_Iallreduce(values.data(), sums.all.data(), count, MPI_UINT64_T, MPI_SUM,
                                   all_, &request),
                    what);
    wait_for(request, what);
    return sums;
  }

  Bytes broadcast(ByteSpan bytes) override {
    const std::string what = "cannot hear " + rank_text(0);
    const auto move = [&](void* data, int length, MPI_Datatype type) {
      MPI_Request request;
      require_success(MPI_Ibcast(data, length, type, 0, all_, &request), what);
      wait_for(request, what);
    };
    std::uint64_t count = bytes.size();
    move(&count, 1, MPI_UINT64_T);
    Bytes all(static_cast<std::size_t>(count));
    if (is_first()) std::ranges::copy(bytes, all.begin());
    in_pieces(all.data(), all.size(),
              [&](std::uint8_t* piece, int length) { move(piece, length, MPI_BYTE); });
    return all;
  }

  void barrier() override {
    const std::string what = "cannot meet the other ranks";
    MPI_Request request;
    require_success(MPI_Ibarrier(all_, &request), what);
    wait_for(request, what);
  }

 private:
  MPI_Comm all_ = MPI_COMM_NULL;
  int rank_ = 0;
  int size_ = 1;
};

MpiJob::MpiJob() {
  int provided = MPI_THREAD_SINGLE;
  require_success(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_MULTIPLE, &provided),
                  "MPI does not start");
  if (provided < MPI_THREAD_MULTIPLE) {
    throw Error(ErrorKind::io, "this MPI cannot be used by two threads at a time");
  }
  ranks_ = std::make_unique<Ranks>();
}

MpiJob::~MpiJob() {
  ranks_.reset();
  MPI_Finalize();
}

Communicator& MpiJob::ranks() { return *ranks_; }

void MpiJob::abort(int status) {
  MPI_Abort(MPI_COMM_WORLD, status);
  std::abort();
}

}  // namespace octavo
