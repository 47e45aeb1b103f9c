#include "octavo/tasks/result_facts.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace octavo {
namespace {

template <class T>
T held(const FactValue& value) {
  return std::get<T>(value.held());
}

TEST(ResultFacts, NumbersAreHeldExactly) {
  constexpr auto kLargest = std::numeric_limits<std::uint64_t>::max();
  constexpr auto kSmallest = std::numeric_limits<std::int64_t>::min();
  EXPECT_EQ(held<std::uint64_t>(kLargest), kLargest);
  EXPECT_EQ(held<std::int64_t>(kSmallest), kSmallest);
  EXPECT_EQ(held<std::int64_t>(-7), -7);
  EXPECT_EQ(held<std::uint64_t>(std::uint8_t{200}), 200u);
  EXPECT_EQ(held<double>(0.5f), 0.5);
  EXPECT_TRUE(held<bool>(true));
}

TEST(ResultFacts, AnOptionalIsItsValueOrNothing) {
  EXPECT_EQ(held<double>(std::optional(2.5)), 2.5);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(
      FactValue(std::optional<std::string>()).held()));
}

TEST(ResultFacts, ListsKeepTheirOrder) {
  const auto list = held<FactValue::List>(std::vector<std::array<int, 2>>{{1, 2}, {3, 4}});
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(held<std::int64_t>(held<FactValue::List>(list[1])[0]), 3);
}

TEST(ResultFacts, AnyTextIsAText) {
  EXPECT_EQ(held<std::string>("lps"), "lps");
  EXPECT_EQ(held<std::string>(std::string("\0", 1)).size(), 1u);
}

}  // namespace
}  // namespace octavo
