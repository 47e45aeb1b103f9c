#include "octavo/tasks/range_words.h"

#include <tuple>

#include "octavo/core/text.h"

namespace octavo {

OutsideWords outside_words(double value, double lowest, double highest) {
  OutsideWords words = {"", number_text(lowest), number_text(highest)};
  const bool is_above = value > highest;
  std::tie(words.value, is_above ? words.highest : words.lowest) =
      unlike_texts(value, is_above ? highest : lowest);
  return words;
}

}  // namespace octavo
