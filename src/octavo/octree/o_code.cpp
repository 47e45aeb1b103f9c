#include "octavo/octree/o_code.h"

#include "octavo/core/error.h"
#include "octavo/core/levels.h"

namespace octavo {

namespace {

// Every third bit: the places of y in a code. Those of x are one higher, those of z two higher.
constexpr std::uint64_t kEveryThird = 0x1249249249249249u;

// abc...u -> a00b00c...00u, doubling the distance between halves until single bits stand apart.
std::uint64_t spread(std::uint64_t v) noexcept {
  v &= 0x00000000001fffffu;
  v = (v | v << 32) & 0x001f00000000ffffu;
  v = (v | v << 16) & 0x001f0000ff0000ffu;
  v = (v | v << 8) & 0x100f00f00f00f00fu;
  v = (v | v << 4) & 0x10c30c30c30c30c3u;
  return (v | v << 2) & kEveryThird;
}

std::int64_t gather(std::uint64_t v) noexcept {
  v &= kEveryThird;
  v = (v | v >> 2) & 0x10c30c30c30c30c3u;
  v = (v | v >> 4) & 0x100f00f00f00f00fu;
  v = (v | v >> 8) & 0x001f0000ff0000ffu;
  v = (v | v >> 16) & 0x001f00000000ffffu;
  v = (v | v >> 32) & 0x00000000001fffffu;
  return static_cast<std::int64_t>(v);
}

// Adds `step` to the axis whose bits are `axis_bits`, all below the code's length; false when that
// leaves the universe. With the foreign bits set a carry runs through them; with them clear a
// borrow does.
bool step_axis(std::uint64_t& code, std::uint64_t axis_bits, int step) noexcept {
  const std::uint64_t mine = code & axis_bits;
  std::uint64_t moved = mine;
  if (step > 0) {
    if (mine == axis_bits) return false;
    moved = ((mine | ~axis_bits) + 1) & axis_bits;
  } else if (step < 0) {
    if (mine == 0) return false;
    moved = (mine - 1) & axis_bits;
  }
  code = (code & ~axis_bits) | moved;
  return true;
}

consteval std::array<Direction, 26> make_directions() {
  std::array<Direction, 26> directions{};
  std::size_t next = 0;
  for (int kind = 1; kind <= 3; ++kind) {
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          if (x * x + y * y + z * z == kind) directions[next++] = {x, y, z};
        }
      }
    }
  }
  return directions;
}

// The code of the last voxel of a cube: in post-order nothing below the cube comes after it.
std::uint64_t last_voxel(const OCode& cube) noexcept {
  return (cube.code + 1) * cube_volume(cube.level) - 1;
}

[[noreturn]] void reject_text(std::string_view text, const std::string& why) {
  throw Error(ErrorKind::invalid_argument, "o-code '" + escaped(text) + "': " + why);
}

void append_digits(std::string& text, const OCode& cube, int n) {
  for (int i = n - cube.level - 1; i >= 0; --i) {
    text.push_back(static_cast<char>('0' + (cube.code >> 3 * i & 7)));
  }
}

}  // namespace

constinit const std::array<Direction, 26> kDirections = make_directions();

std::uint64_t interleave(const Index3& position) noexcept {
  return spread(static_cast<std::uint64_t>(position.z)) << 2 |
         spread(static_cast<std::uint64_t>(position.x)) << 1 |
         spread(static_cast<std::uint64_t>(position.y));
}

Index3 deinterleave(std::uint64_t code) noexcept {
  return {gather(code >> 1), gather(code), gather(code >> 2)};
}

int universe_level(const Size3& size) {
  checked_voxel_count(size);
  int n = 0;
  while (cube_side(n) < std::max({size.x, size.y, size.z})) ++n;
  return n;
}

bool is_valid(const OCode& cube, int n) noexcept {
  return n >= 0 && n <= kMaxUniverseLevel && cube.level >= 0 && cube.level <= n &&
         cube.code < cube_volume(n - cube.level);
}

OCode cube_at(const Index3& voxel, int level) noexcept {
  return {level, interleave(voxel) >> 3 * level};
}

Index3 corner_of(const OCode& cube) noexcept {
  const Index3 p = deinterleave(cube.code);
  return {p.x << cube.level, p.y << cube.level, p.z << cube.level};
}

Box box_of(const OCode& cube) noexcept {
  const Index3 lo = corner_of(cube);
  const std::int64_t side = cube_side(cube.level);
  return {lo, {lo.x + side, lo.y + side, lo.z + side}};
}

std::array<OCode, 8> children_of(const OCode& cube) noexcept {
  std::array<OCode, 8> children{};
  for (int octant = 0; octant < 8; ++octant) {
    children[static_cast<std::size_t>(octant)] = child_of(cube, octant);
  }
  return children;
}

std::optional<OCode> neighbor_of(const OCode& cube, const Direction& direction, int n) noexcept {
  const std::uint64_t all = cube_volume(n - cube.level) - 1;
  std::uint64_t code = cube.code;
  if (!step_axis(code, kEveryThird << 1 & all, direction.x)) return {};
  if (!step_axis(code, kEveryThird & all, direction.y)) return {};
  if (!step_axis(code, kEveryThird << 2 & all, direction.z)) return {};
  return OCode{cube.level, code};
}

std::array<std::optional<OCode>, 26> neighbors_of(const OCode& cube, int n) noexcept {
  std::array<std::optional<OCode>, 26> neighbors;
  for (std::size_t i = 0; i < neighbors.size(); ++i) {
    neighbors[i] = neighbor_of(cube, kDirections[i], n);
  }
  return neighbors;
}

bool is_before_in_post_order(const OCode& a, const OCode& b) noexcept {
  const std::uint64_t end_a = last_voxel(a);
  const std::uint64_t end_b = last_voxel(b);
  return end_a != end_b ? end_a < end_b : a.level < b.level;
}

std::string to_mixed_octal(const OCode& cube, int n) {
  std::string text;
  append_digits(text, cube, n);
  text.append(static_cast<std::size_t>(cube.level), '8');
  return text;
}

std::string to_hierarchical(const OCode& cube, int n) {
  std::string text;
  append_digits(text, cube, n);
  return text;
}

OCode parse_mixed_octal(std::string_view text) {
  if (text.size() > kMaxUniverseLevel) {
    reject_text(text, std::to_string(text.size()) + " characters; at most 21 are possible");
  }
  OCode cube;
  for (const char c : text) {
    if (c == '8') {
      ++cube.level;
    } else if (c < '0' || c > '7') {
      reject_text(text, "only the digits 0 to 7 and the marker 8 may stand in it");
    } else if (cube.level > 0) {
      reject_text(text, "a digit follows the marker 8; markers stand at the end only");
    } else {
      cube.code = cube.code << 3 | static_cast<std::uint64_t>(c - '0');
    }
  }
  return cube;
}

OCode parse_hierarchical(std::string_view text, int n) {
  if (n < 0 || n > kMaxUniverseLevel) {
    throw Error(ErrorKind::invalid_argument,
                "root level " + std::to_string(n) + "; it must be between 0 and 21");
  }
  if (text.size() > static_cast<std::size_t>(n)) {
    reject_text(text, std::to_string(text.size()) + " digits; a universe of side 2^" +
                          std::to_string(n) + " has at most " + std::to_string(n));
  }
  OCode cube{n - static_cast<int>(text.size()), 0};
  for (const char c : text) {
    if (c < '0' || c > '7') reject_text(text, "only the digits 0 to 7 may stand in it");
    cube.code = cube.code << 3 | static_cast<std::uint64_t>(c - '0');
  }
  return cube;
}

}  // namespace octavo
