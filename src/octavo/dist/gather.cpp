#include "octavo/dist/gather.h"

#include "octavo/file/byte_codec.h"

namespace octavo {

namespace {

GatherSteps tree_steps(int rank, int size) {
  GatherSteps steps;
  for (const int child : {2 * rank + 1, 2 * rank + 2}) {
    if (child < size) steps.hears.push_back(child);
  }
  steps.tells = rank == 0 ? -1 : (rank - 1) / 2;
  return steps;
}

// Ranks in a row: the largest power of 2 whose square is no more than `size`; the last row may be
// shorter.
int row_length(int size) {
  int length = 1;
  while (4 * length * length <= size) length *= 2;
  return length;
}

// Adds the steps along a line of `count` places, of which this rank is number `place`. Returns
// whether it has told another.
bool add_line(GatherSteps& steps, int place, int count, int rank, int stride) {
  for (int distance = 1; distance < count; distance *= 2) {
    if (place % (2 * distance) != 0) {
      steps.tells = rank - distance * stride;
      return true;
    }
    if (place + distance < count) steps.hears.push_back(rank + distance * stride);
  }
  return false;
}

GatherSteps mesh_steps(int rank, int size) {
  const int length = row_length(size);
  const int row = rank / length;
  const int rows = (size + length - 1) / length;
  const int in_row = row + 1 < rows ? length : size - row * length;
  GatherSteps steps;
  if (!add_line(steps, rank % length, in_row, rank, 1)) add_line(steps, row, rows, rank, length);
  return steps;
}

void put_given(Bytes& out, int rank, ByteSpan bytes) {
  ByteWriter writer(out);
  writer.put_varint(static_cast<std::uint64_t>(rank));
  writer.put_varint(bytes.size());
  out.insert(out.end(), bytes.begin(), bytes.end());
}

}  // namespace

GatherSteps steps_of(GatherPlan plan, int rank, int size) {
  return plan == GatherPlan::tree ? tree_steps(rank, size) : mesh_steps(rank, size);
}

std::vector<Bytes> gather(GatherPlan plan, Communicator& ranks, ByteSpan own,
                          std::uint64_t* sent) {
  const GatherSteps steps = steps_of(plan, ranks.rank(), ranks.size());
  Bytes heard;
  put_given(heard, ranks.rank(), own);
  for (const int other : steps.hears) {
    const Bytes bytes = ranks.receive(other);
    heard.insert(heard.end(), bytes.begin(), bytes.end());
  }
  if (steps.tells >= 0) {
    ranks.send(steps.tells, heard);
    if (sent != nullptr) *sent += heard.size();
    return {};
  }
  std::vector<Bytes> all(static_cast<std::size_t>(ranks.size()));
  ByteReader in(heard, "what ranks gave");
  while (in.left() > 0) {
    const std::uint64_t rank = in.varint();
    if (rank >= all.size()) in.fail("of a rank that is none");
    const ByteSpan bytes = in.take(static_cast<std::size_t>(in.varint()));
    all[static_cast<std::size_t>(rank)].assign(bytes.begin(), bytes.end());
  }
  return all;
}

}  // namespace octavo
