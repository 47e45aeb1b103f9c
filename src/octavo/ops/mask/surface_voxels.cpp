#include "octavo/ops/mask/surface_voxels.h"

#include <bit>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/ops/mask/mask_pieces.h"
#include "octavo/ops/mask/neighborhood.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr Connectivity kFaces = Connectivity::faces;
// The rank of cubes that are work for one thread: 64^3 voxels.
constexpr int kPieceRank = 1;

// The bits of the center whose six neighbors are all set.
std::uint64_t enclosed(const WordsAround& words) {
  std::uint64_t bits = kFullWord;
  for (int axis = 0; axis < 3; ++axis) {
    bits &= beside_along(words, axis, 1) & beside_along(words, axis, -1);
  }
  return bits;
}

// The children of the center that hold surface.
std::uint64_t surface_children(const CubesAround& around) {
  WordsAround full;
  for (std::size_t i = 0; i < full.size(); ++i) full[i] = around[i].full;
  return around[kCenter].mixed | (full[kCenter] & ~enclosed(full));
}

struct Task {
  std::uint64_t code;
  CubesAround around;
};

void collect(const MaskTree& mask, int rank, std::uint64_t code, const CubesAround& around,
             std::vector<Task>& tasks) {
  if (rank == kPieceRank) {
    tasks.push_back({code, around});
    return;
  }
  for (std::uint64_t left = surface_children(around); left != 0; left &= left - 1) {
    const int bit = std::countr_zero(left);
    collect(mask, rank - 1, code << 6 | static_cast<std::uint64_t>(bit),
            cubes_around_child(mask, rank, around, bit, kFaces), tasks);
  }
}

MaskCube surface_of_words(const MaskTree& mask, const CubesAround& around, MaskArrays& out) {
  WordCube words;
  for (std::uint64_t left = surface_children(around); left != 0; left &= left - 1) {
    const int bit = std::countr_zero(left);
    const WordsAround here = words_around_child(mask, around, bit, kFaces);
    words.add(bit, here[kCenter] & ~enclosed(here));
  }
  return words.finish(out.words);
}

MaskPart surface_of(const MaskTree& mask, const Task& task) {
  MaskPart part;
  part.below = arrays_below(kPieceRank);
  MaskCube cube;
  for (std::uint64_t left = surface_children(task.around); left != 0; left &= left - 1) {
    const int bit = std::countr_zero(left);
    const CubesAround below = cubes_around_child(mask, kPieceRank, task.around, bit, kFaces);
    add_child(surface_of_words(mask, below, part.below), bit, cube, part.below.cubes[0]);
  }
  part.pieces.push_back({task.code, cube});
  return part;
}

}  // namespace

MaskTree surface_voxels(const MaskTree& mask, const Progress& watcher) {
  std::vector<Task> tasks;
  collect(mask, mask.rank_count() - 1, 0, around_root(mask), tasks);
  std::vector<MaskPart> parts(tasks.size());
  parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t i) {
    if (watcher.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    parts[i] = surface_of(mask, tasks[i]);
  });
  return assemble(mask.size(), kPieceRank, parts);
}

}  // namespace octavo
