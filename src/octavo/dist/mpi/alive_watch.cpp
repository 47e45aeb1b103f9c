#include <mpi.h>

#include <chrono>
#include <cstdio>
#include <thread>
#include <utility>

#include "octavo/dist/mpi/mpi_communicator.h"

namespace octavo {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPulseTag = 2;
constexpr std::chrono::milliseconds kPulse{250};

enum PulseWord : int { kHere = 1, kLast = 2 };

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string silence_text(int rank, double seconds) {
  char text[64];
  std::snprintf(text, sizeof text, "rank %d has been silent for %.0f s", rank, seconds);
  return text;
}

std::string stall_text(int rank, double seconds) {
  char text[80];
  std::snprintf(text, sizeof text, "the work of rank %d has stood still for %.0f s", rank,
                seconds);
  return text;
}

}  // namespace

class AliveWatch::Thread {
 public:
  Thread(MpiJob& job, const AliveLimits& limits, const RankPulse& pulse,
         std::function<void(const std::string&)> on_lost)
      : limits_(limits), pulse_(pulse), on_lost_(std::move(on_lost)) {
    MPI_Comm_dup(MPI_COMM_WORLD, &ring_);
    const int size = job.ranks().size();
    rank_ = job.ranks().rank();
    next_ = (rank_ + 1) % size;
    previous_ = (rank_ + size - 1) % size;
    thread_ = std::thread([this] { run(); });
  }

  ~Thread() {
    is_ending_ = true;
    thread_.join();
    MPI_Comm_free(&ring_);
  }
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;

 private:
  // Until both sides of this rank have said their last word.
  void run() {
    heard_ = stepped_ = Clock::now();
    bool has_ended = false;
    while (!(has_ended && has_heard_last_) && !is_lost_) {
      if (!has_ended) {
        has_ended = is_ending_;
        say(has_ended ? kLast : kHere);
      }
      listen();
      look_at_work();
      std::this_thread::sleep_for(kPulse);
    }
  }

  void say(int word) {
    MPI_Request request;
    MPI_Isend(&word, 1, MPI_INT, next_, kPulseTag, ring_, &request);
    // So short a message is copied at once.
    int is_done = 0;
    while (is_done == 0) {
      MPI_Test(&request, &is_done, MPI_STATUS_IGNORE);
      if (is_done == 0) std::this_thread::yield();
    }
  }

  void listen() {
    for (;;) {
      int has_word = 0;
      MPI_Iprobe(previous_, kPulseTag, ring_, &has_word, MPI_STATUS_IGNORE);
      if (has_word == 0) break;
      int word = 0;
      MPI_Recv(&word, 1, MPI_INT, previous_, kPulseTag, ring_, MPI_STATUS_IGNORE);
      has_heard_last_ = word == kLast;
      heard_ = Clock::now();
    }
    const double silent = seconds_since(heard_);
    if (!has_heard_last_ && silent > limits_.silent_s) lose(silence_text(previous_, silent));
  }

  void look_at_work() {
    const std::uint64_t steps = pulse_.steps;
    if (steps != steps_ || !pulse_.is_at_work) {
      steps_ = steps;
      stepped_ = Clock::now();
    }
    const double stalled = seconds_since(stepped_);
    if (limits_.stalled_s > 0 && stalled > limits_.stalled_s) lose(stall_text(rank_, stalled));
  }

  void lose(const std::string& text) {
    is_lost_ = true;
    on_lost_(text);
  }

  AliveLimits limits_;
  const RankPulse& pulse_;
  std::function<void(const std::string&)> on_lost_;
  MPI_Comm ring_ = MPI_COMM_NULL;
  int rank_ = 0;
  int next_ = 0;
  int previous_ = 0;
  Clock::time_point heard_;
  Clock::time_point stepped_;
  std::uint64_t steps_ = 0;
  bool has_heard_last_ = false;
  bool is_lost_ = false;
  std::atomic<bool> is_ending_ = false;
  std::thread thread_;
};

AliveWatch::AliveWatch(MpiJob& job, const AliveLimits& limits, const RankPulse& pulse,
                       std::function<void(const std::string&)> on_lost)
    : thread_(std::make_unique<Thread>(job, limits, pulse, std::move(on_lost))) {}

AliveWatch::~AliveWatch() = default;

}  // namespace octavo
