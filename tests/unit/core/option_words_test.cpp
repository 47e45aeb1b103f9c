#include "octavo/core/option_words.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

enum class Weather { sun, rain, hail };

constexpr auto option_words(Weather) {
  using enum Weather;
  return std::to_array<NamedValue<Weather>>({{"sun", sun}, {"rain", rain}});
}

TEST(OptionWords, EveryWordMeansItsValue) {
  for (const auto& [word, meaning] : option_words(Weather())) {
    EXPECT_STREQ(word_of(meaning), word);
    EXPECT_EQ(value_of_word<Weather>(word), meaning);
  }
}

TEST(OptionWords, OtherTextMeansNothing) {
  EXPECT_EQ(value_of_word<Weather>(""), std::nullopt);
  EXPECT_EQ(value_of_word<Weather>("Sun"), std::nullopt);
  EXPECT_EQ(value_of_word<Weather>("rain "), std::nullopt);
}

TEST(OptionWords, AValueWithoutWordHasNone) { EXPECT_STREQ(word_of(Weather::hail), ""); }

}  // namespace
}  // namespace octavo
