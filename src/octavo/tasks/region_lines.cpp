#include "octavo/tasks/region_lines.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <string>
#include <string_view>

#include "octavo/core/error.h"
#include "octavo/tasks/files/part_result.h"

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

[[noreturn]] void fail_region(const std::string& name) {
  throw Error(ErrorKind::corrupt,
              "no result of a part, or damaged: '" + name + "' is no sum of voxels; make it anew");
}

// More than a part measures: 2^46 voxels of 32 bits. What all parts add up to overflows nothing.
constexpr std::int64_t kMostCount = std::int64_t{1} << 46;
constexpr __int128 kMostSum = static_cast<__int128>(1) << 110;
static_assert(WorkPart::kMostParts <= 1 << 16);

/// Digits as ExactSum has them: all but the last in [0, 2^32), and the last far from overflowing.
template <std::size_t kCount>
std::array<std::int64_t, kCount> exact_digits(const JsonObject& line, const std::string& name) {
  constexpr std::int64_t kBase = std::int64_t{1} << 32;
  std::array<std::int64_t, kCount> digits;
  std::ranges::copy(integers_in(line, name, kCount), digits.begin());
  for (std::size_t i = 0; i < kCount; ++i) {
    const std::int64_t lowest = i + 1 < kCount ? 0 : -kBase;
    if (digits[i] < lowest || digits[i] >= kBase) fail_region(name);
  }
  return digits;
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
  const bool is_negative =
      std::ranges::any_of(counts, [](std::int64_t count) { return count < 0; });
  if (is_negative || counts[0] > kMostCount || counts[1] > counts[0] || counts[2] > counts[0]) {
    fail_region("counts");
  }
  sums.moments.count = static_cast<std::uint64_t>(counts[0]);
  sums.surface = static_cast<std::uint64_t>(counts[1]);
  sums.not_finite = static_cast<std::uint64_t>(counts[2]);
  sums.moments.box = {{counts[3], counts[4], counts[5]}, {counts[6], counts[7], counts[8]}};
  sums.minimum = std::bit_cast<double>(bits_of_digits(text_in(line, "minimum")));
  sums.maximum = std::bit_cast<double>(bits_of_digits(text_in(line, "maximum")));
  int place = 0;
  for (auto* const number : whole_numbers(sums)) {
    const std::string name = "sum" + std::to_string(place++);
    *number = whole_of(text_in(line, name));
    if (*number > kMostSum || *number < -kMostSum) fail_region(name);
  }
  sums.floats = ExactSum(exact_digits<ExactSum::kSumDigits>(line, "float_sum"),
                         exact_digits<ExactSum::kSquareDigits>(line, "float_squares"));
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
