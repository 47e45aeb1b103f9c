// Instruction sets the codecs are compiled for: those whose vectors have a size known to the
// compiler. Include before <hwy/foreach_target.h>.
#pragma once

#ifdef OCTAVO_FEW_TARGETS
// Processors older than SSE4 run the portable code.
#define HWY_DISABLED_TARGETS \
  (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV | HWY_SSSE3)
#else
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#endif
