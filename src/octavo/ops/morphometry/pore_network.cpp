#include "octavo/ops/morphometry/pore_network.h"

namespace octavo {

namespace {

constexpr std::int64_t kReachedAtOnce = 1 << 20;  // between two looks whether to stop
constexpr std::uint8_t kFromFirst = 1;
constexpr std::uint8_t kFromLast = 2;

/// Marks with a bit what hangs together with the pores of one plane.
class PoreFlood {
 public:
  PoreFlood(const std::vector<std::uint8_t>& pores, const Size3& size, int axis)
      : pores_(pores), size_(size), axis_(axis), steps_{1, size.x, size.x * size.y} {}

  template <class Stop>
  void from_plane(std::int64_t plane, std::uint8_t bit, std::vector<std::uint8_t>& reached,
                  Stop stop_if_cancelled) {
    const auto reach = [&](std::int64_t voxel) {
      const auto at = static_cast<std::size_t>(voxel);
      if (pores_[at] == 0 || (reached[at] & bit) != 0) return;
      reached[at] |= bit;
      next_.push_back(voxel);
    };
    const int u = (axis_ + 1) % 3;
    const int v = (axis_ + 2) % 3;
    for (std::int64_t i = 0; i < size_[u]; ++i) {
      for (std::int64_t j = 0; j < size_[v]; ++j) {
        reach(plane * step(axis_) + i * step(u) + j * step(v));
      }
    }
    for (std::int64_t count = 0; !next_.empty(); ++count) {
      if (count % kReachedAtOnce == 0) stop_if_cancelled();
      const std::int64_t voxel = next_.back();
      next_.pop_back();
      for (int a = 0; a < 3; ++a) {
        const std::int64_t place = voxel / step(a) % size_[a];
        if (place > 0) reach(voxel - step(a));
        if (place + 1 < size_[a]) reach(voxel + step(a));
      }
    }
  }

 private:
  std::int64_t step(int axis) const { return steps_[static_cast<std::size_t>(axis)]; }

  const std::vector<std::uint8_t>& pores_;
  Size3 size_;
  int axis_;
  std::array<std::int64_t, 3> steps_;
  std::vector<std::int64_t> next_;
};

}  // namespace

PoreNetwork::PoreNetwork(const std::vector<std::uint8_t>& pores, const Size3& size,
                         const Point3& spacing_mm, int axis, const Progress& progress)
    : size_(size), axis_(axis), spacing_(spacing_mm), progress_(progress) {
  for (std::size_t a = 0; a < 3; ++a) {
    conductance_[a] = spacing_[(a + 1) % 3] * spacing_[(a + 2) % 3] / spacing_[a];
  }
  for (std::size_t bits = 0; bits < 256; ++bits) {
    double sum = 0;
    for (std::size_t side = 0; side < 6; ++side) {
      if ((bits >> side & 1) != 0) sum += conductance_[side / 2];
    }
    diagonal_[bits] = sum + to_ends(static_cast<unsigned>(bits));
  }
  std::vector<std::uint8_t> reached(pores.size());
  {
    PoreFlood flood(pores, size, axis);
    const auto stop = [&] { stop_if_cancelled(); };
    flood.from_plane(0, kFromFirst, reached, stop);
    flood.from_plane(size[axis] - 1, kFromLast, reached, stop);
  }
  number(reached);
  look_around();
}

void PoreNetwork::number(const std::vector<std::uint8_t>& reached) {
  numbers_.assign(reached.size(), 0);
  no_numbers_.assign(static_cast<std::size_t>(size_.x), 0);
  row_starts_.assign(static_cast<std::size_t>(row_count()) + 1, 1);
  const auto count = std::count(reached.begin(), reached.end(), kFromFirst | kFromLast);
  if (count > kMostPores) {
    throw Error(ErrorKind::limit_exceeded, "more than 2^31 - 2 voxels of pores that lead through");
  }
  along_x_.reserve(static_cast<std::size_t>(count) + 1);
  along_x_.push_back(0);
  std::size_t voxel = 0;
  for (std::size_t r = 0; r + 1 < row_starts_.size(); ++r) {
    if (static_cast<std::int64_t>(r) % rows_at_once() == 0) stop_if_cancelled();
    for (std::int32_t x = 0; x < size_.x; ++x, ++voxel) {
      if (reached[voxel] != (kFromFirst | kFromLast)) continue;
      numbers_[voxel] = static_cast<std::int32_t>(along_x_.size());
      along_x_.push_back(x);
    }
    row_starts_[r + 1] = static_cast<std::int32_t>(along_x_.size());
  }
}

void PoreNetwork::look_around() {
  faces_.assign(along_x_.size(), 0);
  for_rows([&](const PoreRow& row) {
    const RowsBeside beside = rows_beside(row);
    for (std::int32_t pore = row.begin; pore < row.end; ++pore) {
      const auto i = static_cast<std::size_t>(pore);
      const std::int32_t x = along_x_[i];
      unsigned bits = 0;
      if (pore > row.begin && along_x_[i - 1] == x - 1) bits |= kPoreBefore;
      if (pore + 1 < row.end && along_x_[i + 1] == x + 1) bits |= kPoreBehind;
      for (std::size_t side = 0; side < 4; ++side) {
        if (beside[side][x] != 0) bits |= kFirstPoreAcross << side;
      }
      const std::int64_t place = along(pore, row);
      if (place == 0) bits |= kAtFirstPlane;
      if (place + 1 == size_[axis_]) bits |= kAtLastPlane;
      faces_[i] = static_cast<std::uint8_t>(bits);
    }
  });
}

}  // namespace octavo
