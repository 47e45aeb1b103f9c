#include "octavo/dist/rank_report.h"

#include <sys/resource.h>

#include <algorithm>
#include <bit>

#include "octavo/file/byte_codec.h"

namespace octavo {

std::uint64_t RankReport::codes() const {
  std::uint64_t sum = 0;
  for (const LevelTraffic& row : levels) sum += row.codes;
  return sum;
}

std::uint64_t RankReport::codes_sent() const {
  std::uint64_t sum = 0;
  for (const LevelTraffic& row : levels) sum += row.sent;
  return sum;
}

std::uint64_t RankReport::bytes_sent() const {
  std::uint64_t sum = 0;
  for (const RankShare& rank : ranks) sum += rank.message_bytes;
  return sum;
}

std::uint64_t RankReport::held() const {
  std::uint64_t sum = 0;
  for (const RankShare& rank : ranks) sum += rank.held;
  return sum;
}

double RankReport::speed_up() const {
  double sum = 0;
  double busiest = 0;
  for (const RankShare& rank : ranks) {
    sum += rank.processor_seconds;
    busiest = std::max(busiest, rank.processor_seconds);
  }
  return busiest > 0 ? sum / busiest : 1;
}

int hop_count(GatherPlan plan, int rank, int size) {
  int hops = 0;
  for (int at = rank; at != 0; at = steps_of(plan, at, size).tells) ++hops;
  return hops;
}

std::vector<RankShare> collect_shares(Communicator& ranks, const RankShare& own) {
  Bytes bytes;
  ByteWriter out(bytes);
  for (const std::uint64_t number : {own.units, own.top_codes, own.message_bytes, own.held,
                                     std::bit_cast<std::uint64_t>(own.processor_seconds)}) {
    out.put_u64(number);
  }
  std::vector<RankShare> shares;
  for (const Bytes& given : ranks.collect(bytes)) {
    ByteReader in(given, "the share of a rank");
    RankShare share{in.u64(), in.u64(), in.u64(), in.u64(), 0};
    share.processor_seconds = std::bit_cast<double>(in.u64());
    shares.push_back(share);
  }
  return shares;
}

double processor_seconds() {
  double seconds = 0;
  for (const int whose : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    struct rusage used {};
    getrusage(whose, &used);
    for (const timeval& time : {used.ru_utime, used.ru_stime}) {
      seconds += static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
    }
  }
  return seconds;
}

}  // namespace octavo
