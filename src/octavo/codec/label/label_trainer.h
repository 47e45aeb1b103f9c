// Fits the networks of a label model to sample questions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/codec/label/label_learning.h"
#include "octavo/codec/label/label_model.h"
#include "octavo/codec/label/label_net.h"
#include "octavo/codec/label/label_walk.h"

namespace octavo {

/// Questions and their answers, thinned evenly to a bounded number.
class LabelSamples {
 public:
  explicit LabelSamples(std::size_t capacity = std::size_t{1} << 16) : capacity_(capacity) {}

  /// Counts a question; true when it is to be added.
  bool wants_next() { return (seen_count_++ & (stride_ - 1)) == 0; }
  void add(const LabelQuestion& question, bool answer);

  const std::vector<LabelSample>& list() const { return list_; }
  /// How many were counted.
  std::uint64_t seen_count() const { return seen_count_; }

 private:
  std::size_t capacity_;
  std::vector<LabelSample> list_;
  std::uint64_t seen_count_ = 0;
  std::uint64_t stride_ = 1;  ///< a power of two
};

/// Keeps the questions of every network, at most `capacity` of each.
class LabelSampleCollector final : public LabelObserver {
 public:
  explicit LabelSampleCollector(std::size_t capacity = std::size_t{1} << 16) {
    samples_.fill(LabelSamples(capacity));
  }

  bool wants_next(LabelAsk kind) override {
    return samples_[static_cast<std::size_t>(kind)].wants_next();
  }
  void observe(LabelAsk kind, const LabelQuestion& question, bool answer) override {
    samples_[static_cast<std::size_t>(kind)].add(question, answer);
  }
  const LabelSamples& of(std::size_t net) const { return samples_[net]; }

 private:
  std::array<LabelSamples, kLabelNets> samples_;
};

struct LabelTraining {
  int epochs = 2;
  float rate = 0.02f;  ///< of the first step; falls to nearly 0
  /// What storing a weight's move by 1 costs, in natural units of information over all samples
  /// seen.
  float move_cost = 28;
  int step = 1;  ///< weights move by whole numbers of it
};

/// `start` moved to answer `samples`, kept of `seen_count`, better. A weight moves only where the
/// bits it saves on all samples seen outweigh what storing its move costs.
/// Deterministic on every machine: IEEE float additions, products, quotients and roots in a fixed
/// order.
/// Time    about 0.1 us per sample and epoch
LabelWeights trained(const LabelWeights& start, std::span<const LabelSample> samples,
                     std::uint64_t seen_count, const LabelTraining& training);

}  // namespace octavo
