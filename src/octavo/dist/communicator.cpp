#include "octavo/dist/communicator.h"

#include <utility>

#include "octavo/file/byte_codec.h"

namespace octavo {

namespace {

Bytes bytes_of(std::span<const std::uint64_t> values) {
  Bytes bytes;
  ByteWriter out(bytes);
  for (const std::uint64_t value : values) out.put_u64(value);
  return bytes;
}

std::vector<std::uint64_t> numbers_of(ByteSpan bytes, std::size_t count) {
  ByteReader in(bytes, "a message of numbers");
  std::vector<std::uint64_t> values(count);
  for (std::uint64_t& value : values) value = in.u64();
  in.expect_end();
  return values;
}

}  // namespace

RankSums Communicator::sum_before(std::span<const std::uint64_t> values) {
  const std::size_t count = values.size();
  const std::vector<Bytes> given = collect(bytes_of(values));
  std::vector<std::uint64_t> sums(count);
  Bytes own;
  for (std::size_t other = 0; other < given.size(); ++other) {
    if (other == 0) own = bytes_of(sums);
    else send(static_cast<int>(other), bytes_of(sums));
    const std::vector<std::uint64_t> added = numbers_of(given[other], count);
    for (std::size_t i = 0; i < count; ++i) sums[i] += added[i];
  }
  if (!is_first()) own = receive(0);
  return {numbers_of(own, count), numbers_of(broadcast(bytes_of(sums)), count)};
}

Bytes Communicator::broadcast(ByteSpan bytes) {
  if (!is_first()) return receive(0);
  for (int other = 1; other < size(); ++other) send(other, bytes);
  return {bytes.begin(), bytes.end()};
}

void Communicator::barrier() {
  collect({});
  broadcast({});
}

std::vector<Bytes> Communicator::collect(ByteSpan bytes) {
  if (!is_first()) {
    send(0, bytes);
    return {};
  }
  std::vector<Bytes> all;
  all.emplace_back(bytes.begin(), bytes.end());
  for (int other = 1; other < size(); ++other) all.push_back(receive(other));
  return all;
}

std::vector<Bytes> Communicator::exchange(std::vector<Bytes> outgoing) {
  std::vector<Bytes> incoming(outgoing.size());
  incoming[static_cast<std::size_t>(rank())] =
      std::move(outgoing[static_cast<std::size_t>(rank())]);
  // Pairs speak in turns, so that none waits for another that waits.
  for (int round = 1; round < 2 * size(); ++round) {
    const int other = rank() ^ round;
    if (other >= size()) continue;
    const auto at = static_cast<std::size_t>(other);
    if (rank() < other) send(other, outgoing[at]);
    incoming[at] = receive(other);
    if (rank() > other) send(other, outgoing[at]);
    outgoing[at].clear();
  }
  return incoming;
}

}  // namespace octavo
