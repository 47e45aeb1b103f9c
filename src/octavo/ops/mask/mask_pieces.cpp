#include "octavo/ops/mask/mask_pieces.h"

#include <algorithm>
#include <utility>

namespace octavo {

namespace {

std::size_t rank_index(int rank) { return static_cast<std::size_t>(rank); }

// Adds the cubes of all parts at `rank`, whose children were moved by what stands before them.
void append_part(const MaskArrays& part, MaskArrays& out) {
  std::uint64_t moved = out.words.size();
  out.words.insert(out.words.end(), part.words.begin(), part.words.end());
  for (std::size_t rank = 0; rank < part.cubes.size(); ++rank) {
    std::vector<MaskCube>& to = out.cubes[rank];
    const std::uint64_t moved_above = to.size();
    for (MaskCube cube : part.cubes[rank]) {
      cube.first += moved;
      to.push_back(cube);
    }
    moved = moved_above;
  }
}

// The ranks above the pieces, in o-code order.
class Roof {
 public:
  Roof(int rank, std::span<const MaskPiece> pieces, MaskArrays& out)
      : rank_(rank), pieces_(pieces), out_(out) {}

  MaskCube cube(int rank, std::uint64_t code) {
    if (rank == rank_) return pieces_[next_++].cube;
    std::vector<MaskCube>& below = out_.cubes[rank_index(rank) - 1];
    MaskCube made{0, 0, below.size()};
    const int shift = 6 * (rank - 1 - rank_);
    while (next_ < pieces_.size() && pieces_[next_].code >> shift >> 6 == code) {
      const std::uint64_t child_code = pieces_[next_].code >> shift;
      const MaskCube child = cube(rank - 1, child_code);
      add_child(child, static_cast<int>(child_code & 63), made, below);
    }
    return made;
  }

 private:
  int rank_;
  std::span<const MaskPiece> pieces_;
  MaskArrays& out_;
  std::size_t next_ = 0;
};

void collect(const MaskTree& tree, int rank, const MaskCube& cube, std::uint64_t code, int wanted,
             std::vector<MaskPiece>& pieces) {
  if (rank == wanted || cube.is_full()) {
    const int shift = 6 * (rank - wanted);
    const std::uint64_t count = std::uint64_t{1} << shift;
    for (std::uint64_t i = 0; i < count; ++i) pieces.push_back({(code << shift) + i, cube});
    return;
  }
  for (std::uint64_t left = cube.full | cube.mixed; left != 0; left &= left - 1) {
    const int bit = std::countr_zero(left);
    const std::uint64_t below = code << 6 | static_cast<std::uint64_t>(bit);
    const bool is_mixed = (cube.mixed >> bit & 1) != 0;
    const MaskCube child =
        is_mixed ? tree.cubes(rank - 1)[cube.place_of(bit)] : MaskCube{kFullWord, 0, 0};
    collect(tree, rank - 1, child, below, wanted, pieces);
  }
}

}  // namespace

MaskArrays arrays_below(int rank) {
  MaskArrays arrays;
  arrays.cubes.resize(rank_index(rank));
  return arrays;
}

std::uint64_t memory_bytes(const MaskPart& part) noexcept {
  std::uint64_t bytes = sizeof part + part.pieces.size() * sizeof(MaskPiece) +
                        part.below.words.size() * sizeof(std::uint64_t);
  for (const auto& cubes : part.below.cubes) {
    bytes += sizeof(std::vector<MaskCube>) + cubes.size() * sizeof(MaskCube);
  }
  return bytes;
}

MaskPart fold_cube(const std::uint64_t* words, std::uint64_t code) {
  MaskPart part;
  part.below = arrays_below(1);
  MaskCube cube;
  for (int bit = 0; bit < 64; ++bit) {
    WordCube child;
    for (int inner = 0; inner < 64; ++inner) child.add(inner, words[64 * bit + inner]);
    add_child(child.finish(part.below.words), bit, cube, part.below.cubes[0]);
  }
  part.below.words.shrink_to_fit();
  part.below.cubes[0].shrink_to_fit();
  part.pieces.push_back({code, cube});
  return part;
}

MaskTree assemble(const Size3& size, int rank, std::span<const MaskPart> parts) {
  const int rank_count = MaskTree::rank_count_for(size);
  MaskArrays out = arrays_below(rank_count);
  std::size_t piece_count = 0;
  MaskArrays below = arrays_below(rank);
  std::size_t word_count = 0;
  for (const MaskPart& part : parts) {
    piece_count += part.pieces.size();
    word_count += part.below.words.size();
  }
  out.words.reserve(word_count);
  std::vector<MaskPiece> pieces;
  pieces.reserve(piece_count);
  for (const MaskPart& part : parts) {
    const std::uint64_t moved =
        rank == 0 ? out.words.size() : out.cubes[rank_index(rank) - 1].size();
    append_part(part.below, out);
    for (MaskPiece piece : part.pieces) {
      piece.cube.first += moved;
      if (!piece.cube.is_empty()) pieces.push_back(piece);
    }
  }
  Roof roof(rank, pieces, out);
  const MaskCube root = pieces.empty() ? MaskCube{} : roof.cube(rank_count - 1, 0);
  out.cubes.back().push_back(root);
  return {size, std::move(out)};
}

void append_cubes(const MaskTree& from, int rank, std::uint64_t begin, std::uint64_t end,
                  bool is_inverted, MaskArrays& out) {
  for (;; --rank) {
    const std::span<const MaskCube> run = from.cubes(rank).subspan(begin, end - begin);
    std::vector<MaskCube>& to = out.cubes[rank_index(rank)];
    const std::uint64_t first_below =
        rank == 0 ? out.words.size() : out.cubes[rank_index(rank) - 1].size();
    const std::uint64_t moved = first_below - run.front().first;
    const std::uint64_t flip = is_inverted ? kFullWord : 0;
    const std::size_t at = to.size();
    to.insert(to.end(), run.begin(), run.end());
    for (std::size_t i = at; i < to.size(); ++i) {
      to[i].full = (to[i].full ^ flip) & ~to[i].mixed;
      to[i].first += moved;
    }
    begin = run.front().first;
    end = run.back().end();
    if (rank == 0) break;
    if (begin == end) return;
  }
  const std::span<const std::uint64_t> words = from.words().subspan(begin, end - begin);
  const std::size_t at = out.words.size();
  out.words.insert(out.words.end(), words.begin(), words.end());
  if (is_inverted) {
    for (std::size_t i = at; i < out.words.size(); ++i) out.words[i] = ~out.words[i];
  }
}

std::vector<MaskPiece> pieces_at(const MaskTree& tree, int rank) {
  std::vector<MaskPiece> pieces;
  collect(tree, tree.rank_count() - 1, tree.root(), 0, rank, pieces);
  return pieces;
}

}  // namespace octavo
