// A number that lies outside a range, in words.
#pragma once

#include <string>

namespace octavo {

struct OutsideWords {
  std::string value;
  std::string lowest;
  std::string highest;
};

/// Numbers as people write them; the value and the end that it lies beyond have as many digits as
/// tell them apart.
OutsideWords outside_words(double value, double lowest, double highest);

}  // namespace octavo
