// The instruction sets that the codecs find, beside those that Highway's own library finds.
#include "octavo/codec/simd_targets.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#ifdef __linux__
#include <dlfcn.h>
#endif

namespace octavo {
namespace {

#ifdef __linux__
TEST(HighwayTargets, AreThoseOfHighwaysLibrary) {
  // Bound to its own functions, not to those of this program.
  void* const library = ::dlopen("libhwy.so.1", RTLD_NOW | RTLD_LOCAL | RTLD_DEEPBIND);
  ASSERT_NE(library, nullptr) << ::dlerror();
  void* const symbol = ::dlsym(library, "_ZN3hwy16SupportedTargetsEv");
  ASSERT_NE(symbol, nullptr);
  const auto supported = reinterpret_cast<decltype(&hwy::SupportedTargets)>(symbol);
  ASSERT_NE(supported, &hwy::SupportedTargets);
  EXPECT_EQ(hwy::SupportedTargets() & HWY_TARGETS, supported() & HWY_TARGETS);
}
#endif

TEST(HighwayTargets, HoldWhatTheCompilerMayUseEverywhere) {
  EXPECT_EQ(hwy::SupportedTargets() & HWY_ENABLED_BASELINE, HWY_ENABLED_BASELINE);
}

}  // namespace
}  // namespace octavo
