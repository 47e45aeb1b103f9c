// How the top codes of all ranks come to the first one: the two plans of the thesis.
//
//   tree (Fig. 2.8)     rank r hears ranks 2r + 1 and 2r + 2, and tells rank (r - 1) / 2
//   mesh (Fig. 2.9,     ranks stand in rows; along each row, then along the first column, every
//   2.10)               other one tells its neighbor, then every fourth, ..
//
//        0            0 <- 1    2 <- 3      step 1
//      /   \          0 <------ 2           step 2
//     1     2         4 <- 5    6 <- 7      step 1
//    / \   / \        4 <------ 6           step 2
//   3   4 5   6       0 <- 4                step 3
//
// What a rank hears it passes on with its own: every rank but the first sends once.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/core/option_words.h"
#include "octavo/dist/communicator.h"

namespace octavo {

enum class GatherPlan { tree, mesh };

constexpr auto option_words(GatherPlan) { return in_order<GatherPlan>("tree", "mesh"); }

/// From whom a rank hears, in this order, and whom it tells then; -1: none, of the first rank.
struct GatherSteps {
  std::vector<int> hears;
  int tells = -1;
};

GatherSteps steps_of(GatherPlan plan, int rank, int size);

/// Collective: what each rank gives, at rank 0 by their numbers; nothing at the others.
/// sent    when given, grows by the bytes that this rank sends
/// Throws  as Communicator::send; Error{corrupt} for a message that was not sent so
std::vector<Bytes> gather(GatherPlan plan, Communicator& ranks, ByteSpan own,
                          std::uint64_t* sent = nullptr);

}  // namespace octavo
