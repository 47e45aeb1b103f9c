// Fits the networks of a label model to sample questions.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/codec/label_net.h"

namespace octavo {

/// Questions and their answers, thinned evenly to a bounded number.
class LabelSamples {
 public:
  struct Sample {
    LabelQuestion question;
    bool answer = false;
  };

  void add(const LabelQuestion& question, bool answer);

  const std::vector<Sample>& list() const { return list_; }
  /// How many were added, those thinned out included.
  std::uint64_t seen_count() const { return seen_count_; }

 private:
  static constexpr std::size_t kCapacity = 1u << 16;

  std::vector<Sample> list_;
  std::uint64_t seen_count_ = 0;
  std::uint64_t stride_ = 1;
};

/// `start` moved to answer `samples` better, every weight by a whole number of `step`s. A weight
/// moves only where the bits it saves on all samples seen outweigh those that storing its move
/// costs.
/// Deterministic on every machine: IEEE float additions, products, quotients and roots in a fixed
/// order.
/// Time    about 2 us per sample kept
LabelWeights trained(const LabelWeights& start, const LabelSamples& samples, int step);

}  // namespace octavo
