#include "octavo/codec/label/label_trainer.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

TEST(LabelSamples, KeepsEveryNthQuestionOfAllThatWereCounted) {
  constexpr std::size_t kCapacity = 8;
  for (std::size_t count = 1; count <= 200; ++count) {
    LabelSamples samples(kCapacity);
    for (std::size_t i = 0; i < count; ++i) {
      if (!samples.wants_next()) continue;
      samples.add({.neighbor = {}, .first = static_cast<std::uint8_t>(i)}, true);
    }
    EXPECT_EQ(samples.seen_count(), count);
    std::size_t stride = 1;
    while ((count + stride - 1) / stride > kCapacity) stride *= 2;
    ASSERT_EQ(samples.list().size(), (count + stride - 1) / stride);
    for (std::size_t i = 0; i < samples.list().size(); ++i) {
      EXPECT_EQ(samples.list()[i].question.first, i * stride);
    }
  }
}

}  // namespace
}  // namespace octavo
