// Instruction sets the codecs are compiled for: those whose vectors have a size known to the
// compiler. Processors that count bits, as all of Octavo asks for, have SSE4 but for a few that
// run the portable code. Include before <hwy/foreach_target.h>.
#pragma once

#ifndef OCTAVO_FURTHER_DISABLED_TARGETS
#define OCTAVO_FURTHER_DISABLED_TARGETS 0  // of one source
#endif

#define HWY_DISABLED_TARGETS                                               \
  (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV | HWY_SSSE3 | \
   OCTAVO_FURTHER_DISABLED_TARGETS)
