// A transfer function out of the values of a volume of which nothing else is known.
//
//     voxels |#
//            |##            #            two heaps of values: what lies around, and what is looked
//            |####        ####  ##       at; the threshold between them is Otsu's, moved to the
//            +--------|------------- value          bottom of the valley that it lies in
//                 unseen  ...  opaque
//
// What is looked at is taken to be brighter, as in micro-CT, MR and light-sheet scans.
//
// Source  N. Otsu, A threshold selection method from gray-level histograms (1979)
#pragma once

#include <vector>

#include "octavo/render/rays/transfer_function.h"

namespace octavo {

/// Opacity rises from nothing at the threshold through the quartiles of what lies above it.
/// values  real ones, as many as are typical; those that are not finite do not count
/// Returns usual_transfer_function where all values are one.
TransferFunction fitted_transfer(std::vector<double> values);

}  // namespace octavo
