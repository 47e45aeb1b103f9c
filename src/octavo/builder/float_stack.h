// Planes of floats that a coding is chosen by: in memory, or read again when they are looked at.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace octavo {

/// Of each plane its floats, or a single one where all are that.
class FloatStack {
 public:
  /// Fills in the floats of a plane.
  using Read = std::function<void(std::size_t plane, std::span<float> floats)>;

  FloatStack() = default;
  /// read  gives those that are not kept
  explicit FloatStack(Read read) : read_(std::move(read)) {}

  /// A plane that is kept.
  void add(std::vector<float> plane) { planes_.push_back({plane.size(), std::move(plane)}); }
  /// One of so many floats that is read again.
  void add_unkept(std::size_t floats) { planes_.push_back({floats, {}}); }

  std::size_t count() const { return planes_.size(); }
  bool is_empty() const { return planes_.empty(); }
  /// Of all planes, one for a plane whose floats are all alike.
  std::size_t float_count() const;

  /// The floats of a plane. They last until another plane is looked at.
  std::span<const float> plane(std::size_t number) const;

  /// The first plane, which is kept, and no longer in the stack.
  std::vector<float> take_first();

 private:
  struct Plane {
    std::size_t count = 0;
    std::vector<float> floats;  // none where they are read again
  };

  Read read_;
  std::deque<Plane> planes_;
  mutable std::vector<float> read_again_;
};

}  // namespace octavo
