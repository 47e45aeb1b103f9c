#include "octavo/mesh/hexahedra/hex_fan.h"

#include <algorithm>
#include <cstddef>

namespace octavo {

namespace {

constexpr std::array<std::uint8_t, 3> kFanStep = {1, 3, 9};

/// A face with what lies on it: corners, the middles of the edges behind them, its own middle.
struct FanFace {
  std::array<std::uint8_t, 4> corners{};
  std::array<std::uint8_t, 4> middles{};
  std::uint8_t center = 0;
};

FanFace fan_face(int number) {
  FanFace face;
  face.corners = face_corners(number);
  for (std::size_t i = 0; i < 4; ++i) {
    face.middles[i] =
        static_cast<std::uint8_t>((face.corners[i] + face.corners[(i + 1) % 4]) / 2);
  }
  face.center = static_cast<std::uint8_t>((face.corners[0] + face.corners[2]) / 2);
  return face;
}

bool is_there(std::uint32_t points, std::uint8_t point) { return (points >> point & 1) != 0; }

class FanMaker {
 public:
  explicit FanMaker(std::uint32_t points) : points_(points) {}

  std::vector<FanElement> make() {
    for (int number = 0; number < 6; ++number) add_face(number);
    return std::move(elements_);
  }

 private:
  void add_face(int number) {
    face_ = static_cast<std::uint8_t>(number);
    const FanFace face = fan_face(number);
    if (is_there(points_, face.center)) {
      add_around_center(face);
      return;
    }
    std::vector<std::uint8_t> border;
    std::size_t lowest = 8;
    for (std::size_t i = 0; i < 4; ++i) {
      border.push_back(face.corners[i]);
      if (!is_there(points_, face.middles[i])) continue;
      if (lowest == 8 || face.middles[i] < border[lowest]) lowest = border.size();
      border.push_back(face.middles[i]);
    }
    if (lowest == 8) {
      add_square(face.corners[0], face.corners[1], face.corners[2], face.corners[3]);
      return;
    }
    std::rotate(border.begin(), border.begin() + static_cast<std::ptrdiff_t>(lowest),
                border.end());
    for (std::size_t i = 1; i + 1 < border.size(); ++i) {
      add_triangle(border[0], border[i], border[i + 1]);
    }
  }

  void add_around_center(const FanFace& face) {
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint8_t corner = face.corners[i];
      const std::uint8_t before = face.middles[(i + 3) % 4];
      const std::uint8_t behind = face.middles[i];
      if (is_there(points_, before) && is_there(points_, behind)) {
        add_square(face.center, before, corner, behind);
      } else if (is_there(points_, before)) {
        add_triangle(face.center, before, corner);
      } else if (is_there(points_, behind)) {
        add_triangle(face.center, corner, behind);
      }
      if (!is_there(points_, behind)) {
        add_triangle(face.center, corner, face.corners[(i + 1) % 4]);
      }
    }
  }

  void add_square(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d) {
    elements_.push_back({HexShape::pyramid, face_, {a, b, c, d, kFanCenter}});
  }
  void add_triangle(std::uint8_t a, std::uint8_t b, std::uint8_t c) {
    elements_.push_back({HexShape::tetrahedron, face_, {a, b, c, kFanCenter, 0}});
  }

  std::uint32_t points_;
  std::uint8_t face_ = 0;
  std::vector<FanElement> elements_;
};

}  // namespace

std::array<std::uint8_t, 4> face_corners(int face) noexcept {
  const auto axis = static_cast<std::size_t>(face / 2);
  const bool is_upper = face % 2 != 0;
  const int base = is_upper ? 2 * kFanStep[axis] : 0;
  const int first = base + 2 * kFanStep[(axis + 1) % 3];
  const int second = base + 2 * kFanStep[(axis + 2) % 3];
  const int both = first + second - base;
  const auto number = [](int point) { return static_cast<std::uint8_t>(point); };
  if (is_upper) return {number(base), number(second), number(both), number(first)};
  return {number(base), number(first), number(both), number(second)};
}

std::vector<FanElement> fan_of(std::uint32_t points) { return FanMaker(points).make(); }

bool has_lone_quarter(std::uint32_t points) noexcept {
  for (int number = 0; number < 6; ++number) {
    const FanFace face = fan_face(number);
    if (!is_there(points, face.center)) continue;
    const auto has_pair = [&](std::size_t i) {
      return is_there(points, face.middles[i]) && is_there(points, face.middles[i + 2]);
    };
    if (!has_pair(0) && !has_pair(1)) return true;
  }
  return false;
}

}  // namespace octavo
