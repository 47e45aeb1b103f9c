#include "octavo/builder/float_stack.h"

namespace octavo {

std::size_t FloatStack::float_count() const {
  std::size_t count = 0;
  for (const Plane& plane : planes_) count += plane.count;
  return count;
}

std::span<const float> FloatStack::plane(std::size_t number) const {
  const Plane& plane = planes_[number];
  if (!plane.floats.empty()) return plane.floats;
  read_again_.resize(plane.count);
  read_(number, read_again_);
  return read_again_;
}

std::vector<float> FloatStack::take_first() {
  std::vector<float> floats = std::move(planes_.front().floats);
  planes_.pop_front();
  return floats;
}

}  // namespace octavo
