// Which plane a source gives next, and behind which it ends.
#pragma once

#include <cstdint>

namespace octavo {

/// Planes next() .. end() of `count` are to be given.
class PlaneCursor {
 public:
  explicit PlaneCursor(std::int64_t count) : count_(count), end_(count) {}

  /// As PlaneSource::seek. Throws Error{invalid_argument} unless 0 <= first <= end <= count.
  void seek(std::int64_t first, std::int64_t end);

  /// The plane to be given now; moves on. Throws Error{invalid_argument} where none is left.
  std::int64_t take();

  std::int64_t next() const { return next_; }
  std::int64_t end() const { return end_; }
  bool is_done() const { return next_ == end_; }
  /// Whether the last plane of the volume has been taken.
  bool is_behind_last() const { return next_ == count_; }

 private:
  std::int64_t count_;
  std::int64_t next_ = 0;
  std::int64_t end_;
};

}  // namespace octavo
