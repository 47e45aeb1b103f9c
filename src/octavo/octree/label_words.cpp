#include "octavo/octree/label_words.h"

#include <algorithm>
#include <array>
#include <bit>

#include "octavo/octree/o_code.h"
#include "octavo/octree/word_steps.h"

namespace octavo {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

// Of so many labels, those that occur are the bits of a word.
constexpr std::size_t kFewLabels = 64;

// choose_labels for at most kFewLabels.
void choose_of_few(std::span<const std::int64_t> all, LabelWords& words) {
  std::uint64_t found = 0;
  for (const LabelWordPart& part : words.parts) found |= std::uint64_t{1} << part.label;
  words.labels.clear();
  std::array<std::uint32_t, kFewLabels> place_of{};
  for (std::uint64_t left = found; left != 0; left &= left - 1) {
    const auto label = static_cast<std::size_t>(std::countr_zero(left));
    place_of[label] = static_cast<std::uint32_t>(words.labels.size());
    words.labels.push_back(all[label]);
  }
  if (words.labels.size() == all.size()) return;
  for (LabelWordPart& part : words.parts) part.label = place_of[part.label];
}

}  // namespace

void fill_words(const Size3& size, std::int64_t label, LabelWords& words) {
  words.labels = {label};
  words.parts.clear();
  for (std::size_t word = 0; word < LabelWords::kCount; ++word) {
    words.first[word] = static_cast<std::uint32_t>(words.parts.size());
    const Index3 at = deinterleave(word);
    const std::uint64_t bits = bits_within({size.x - 4 * at.x, size.y - 4 * at.y,
                                            size.z - 4 * at.z});
    if (bits != 0) words.parts.push_back({0, bits});
  }
  words.first.back() = static_cast<std::uint32_t>(words.parts.size());
}

void choose_labels(std::span<const std::int64_t> all, LabelWords& words) {
  if (all.size() <= kFewLabels) {
    choose_of_few(all, words);
    return;
  }
  // Which occur: runs of one label are usual.
  std::vector<std::uint32_t> found;
  const auto unite = [&] {
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
  };
  std::uint32_t last = kNone;
  std::size_t room = 1024;
  for (const LabelWordPart& part : words.parts) {
    if (part.label == last) continue;
    last = part.label;
    found.push_back(last);
    if (found.size() < room) continue;
    unite();
    room = std::max(room, 2 * found.size());
  }
  unite();
  words.labels.clear();
  for (const std::uint32_t label : found) words.labels.push_back(all[label]);

  // Their places among those.
  last = kNone;
  std::uint32_t place = 0;
  for (LabelWordPart& part : words.parts) {
    if (part.label != last) {
      last = part.label;
      place = static_cast<std::uint32_t>(std::lower_bound(found.begin(), found.end(), last) -
                                         found.begin());
    }
    part.label = place;
  }
}

}  // namespace octavo
