#include "octavo/tasks/region_lines.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <string>
#include <string_view>

#include "octavo/core/error.h"
#include "octavo/tasks/files/part_file.h"

namespace octavo {

namespace {

// Readers take twice as many values in a line.
constexpr std::size_t kNumbersPerLine = 32768;

std::string digits_of(__int128 number) {
  const auto bits = static_cast<unsigned __int128>(number);
  return hex_digits(static_cast<std::uint64_t>(bits >> 64)) +
         hex_digits(static_cast<std::uint64_t>(bits));
}

__int128 whole_of(const std::string& digits) {
  const std::string_view all = digits;
  const std::size_t half = std::min<std::size_t>(16, all.size());
  return static_cast<__int128>(
      static_cast<unsigned __int128>(bits_of_digits(all.substr(0, half))) << 64 |
      bits_of_digits(all.substr(half)));
}

/// The numbers of 128 bits, in the order in which they stand in a line.
template <class Sums>
auto whole_numbers(Sums& sums) {
  auto& first = sums.moments.first;
  auto& second = sums.moments.second;
  return std::array{&first[0],  &first[1],  &first[2],  &second[0],     &second[1],
                    &second[2], &second[3], &second[4], &second[5],     &sums.whole_sum,
                    &sums.whole_squares};
}

JsonObject line_of(std::int64_t label, const RegionSums& sums) {
  const Box& box = sums.moments.box;
  JsonObject line;
  line.set("label", std::vector<std::int64_t>{label});
  line.set("counts",
           std::vector<std::int64_t>{static_cast<std::int64_t>(sums.moments.count),
                                     static_cast<std::int64_t>(sums.surface),
                                     static_cast<std::int64_t>(sums.not_finite), box.lo.x,
                                     box.lo.y, box.lo.z, box.hi.x, box.hi.y, box.hi.z});
  line.set("minimum", hex_digits(std::bit_cast<std::uint64_t>(sums.minimum)));
  line.set("maximum", hex_digits(std::bit_cast<std::uint64_t>(sums.maximum)));
  int place = 0;
  for (const auto* const number : whole_numbers(sums)) {
    line.set("sum" + std::to_string(place++), digits_of(*number));
  }
  line.set("float_sum", sums.floats.normal_sum());
  line.set("float_squares", sums.floats.normal_squares());
  return line;
}

RegionSums sums_of(const JsonObject& line) {
  RegionSums sums;
  const auto counts = integers_in(line, "counts", 9);
  sums.moments.count = static_cast<std::uint64_t>(counts[0]);
  sums.surface = static_cast<std::uint64_t>(counts[1]);
  sums.not_finite = static_cast<std::uint64_t>(counts[2]);
  sums.moments.box = {{counts[3], counts[4], counts[5]}, {counts[6], counts[7], counts[8]}};
  sums.minimum = std::bit_cast<double>(bits_of_digits(text_in(line, "minimum")));
  sums.maximum = std::bit_cast<double>(bits_of_digits(text_in(line, "maximum")));
  int place = 0;
  for (auto* const number : whole_numbers(sums)) {
    *number = whole_of(text_in(line, "sum" + std::to_string(place++)));
  }
  ExactSum::SumDigits sum;
  ExactSum::SquareDigits squares;
  std::ranges::copy(integers_in(line, "float_sum", sum.size()), sum.begin());
  std::ranges::copy(integers_in(line, "float_squares", squares.size()), squares.begin());
  sums.floats = ExactSum(sum, squares);
  return sums;
}

/// Keys and counts in turn.
void append_values(std::int64_t label, const std::map<std::uint64_t, std::uint64_t>& values,
                   std::vector<JsonObject>& lines) {
  std::vector<std::int64_t> numbers;
  const auto end_line = [&] {
    if (numbers.empty()) return;
    const auto pairs = static_cast<std::int64_t>(numbers.size());
    JsonObject line;
    line.set("values_of", std::vector<std::int64_t>{label, pairs});
    line.set("values", numbers);
    lines.push_back(line);
    numbers.clear();
  };
  for (const auto& [key, count] : values) {
    numbers.push_back(static_cast<std::int64_t>(key));
    numbers.push_back(static_cast<std::int64_t>(count));
    if (numbers.size() == kNumbersPerLine) end_line();
  }
  end_line();
}

}  // namespace

std::vector<JsonObject> lines_of_regions(const PartOfRegions& regions) {
  std::vector<JsonObject> lines;
  for (const auto& [label, region] : regions) {
    lines.push_back(line_of(label, region.sums));
    append_values(label, region.values, lines);
  }
  return lines;
}

PartOfRegions regions_of_lines(std::span<const JsonObject> lines) {
  PartOfRegions regions;
  for (const JsonObject& line : lines) {
    if (line.json_of("values_of").empty()) {
      regions[integers_in(line, "label", 1).front()].sums = sums_of(line);
      continue;
    }
    const auto of = integers_in(line, "values_of", 2);
    const auto count = static_cast<std::size_t>(
        std::clamp<std::int64_t>(of[1], 0, static_cast<std::int64_t>(kNumbersPerLine)));
    const auto numbers = integers_in(line, "values", count);
    for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) {
      regions[of[0]].values[static_cast<std::uint64_t>(numbers[i])] +=
          static_cast<std::uint64_t>(numbers[i + 1]);
    }
  }
  return regions;
}

}  // namespace octavo
