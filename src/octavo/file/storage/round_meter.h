// What a round of requests costs, in bytes that could have come instead.
//
//     seconds ^              x   a large answer
//             |          x
//             |   x                           extra seconds of its bytes
//             |--x--------------------------  a small one: a round, whatever it brings
//             +-------------------------> bytes
#pragma once

#include <cstdint>
#include <limits>

namespace octavo {

/// Learns from answers of a server how long they take. Not thread-safe.
class RoundMeter {
 public:
  /// An answer of so many bytes that came after so many seconds. Of times that are no positive
  /// numbers nothing is learned.
  void add(double seconds, std::uint64_t bytes);

  /// How many bytes come in the time of the shortest round: at most 16 times as many as have come
  /// with one large answer. 0 until a small and a large one have come.
  std::uint64_t bytes_per_round() const;

 private:
  static constexpr std::uint64_t kSmallBytes = std::uint64_t{1} << 16;
  static constexpr std::uint64_t kLargeBytes = 4 * kSmallBytes;

  double round_seconds_ = std::numeric_limits<double>::infinity();
  double large_seconds_ = 0;
  std::uint64_t large_bytes_ = 0;
};

}  // namespace octavo
