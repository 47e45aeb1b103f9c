// Pairs at the edge of an object: one sample is the smallest value of the brick, the other is not.
//
// Where most of a scan is one background value, masked or segmented, such pairs are frequent, and
// no prediction predicts their details: all that is unknown is which of the two samples lies in the
// background, and whether their sum is odd. Pairs beside background and beside edges are therefore
// asked for ahead of the residuals of a split, row by row, and edges are left out of these.
// Lossless models only.
//
// What a context knows is known before the row is: a row of candidates is listed first, and then
// taken off the streams, which do not wait for each other.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/codec/grey/grey_stage.h"

namespace octavo::grey {

/// Finds the edges of a split in the true details in work.residuals: notes them in work.edges, and
/// the answers for all its candidates in work.edge_symbols.
template <class Sample>
void mark_edges(const Stage& stage, Workspace<Sample>& work);

/// Notes the edges of a split in work.edges as they come off `symbols`.
/// Throws Error{corrupt} when the streams end before.
template <class Sample>
void take_edges(const Stage& stage, Workspace<Sample>& work, SymbolReader& symbols);

}  // namespace octavo::grey
