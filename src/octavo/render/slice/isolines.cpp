#include "octavo/render/slice/isolines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace octavo {

namespace {

/// A side of cells: number 2 * pixel is the one to the right of a pixel, the next the one below it.
using Side = std::int64_t;

/// The crossed sides, each with the one or two that it is joined to.
class Crossings {
 public:
  Crossings(const SectionSamples& field, double level) : field_(field), level_(level) {
    for (std::int64_t y = 0; y + 1 < field.height; ++y) {
      for (std::int64_t x = 0; x + 1 < field.width; ++x) join_cell(x, y);
    }
  }

  std::vector<Isoline> lines() {
    std::vector<Isoline> result;
    // Open lines from their ends, then what is left: closed ones.
    for (const bool is_open : {true, false}) {
      for (const Side side : order_) {
        const Joint& joint = joints_.at(side);
        if (joint.is_taken || (joint.count == 1) != is_open) continue;
        result.push_back(follow(side));
      }
    }
    return result;
  }

 private:
  struct Joint {
    std::array<Side, 2> others{};
    int count = 0;
    bool is_taken = false;
  };

  bool is_below(std::int64_t x, std::int64_t y) const { return field_.at(x, y) < level_; }

  void join_cell(std::int64_t x, std::int64_t y) {
    const double corners[] = {field_.at(x, y), field_.at(x + 1, y), field_.at(x, y + 1),
                              field_.at(x + 1, y + 1)};
    for (const double corner : corners) {
      if (std::isnan(corner)) return;
    }
    const Side top = 2 * (y * field_.width + x);
    const Side left = top + 1;
    const Side bottom = top + 2 * field_.width;
    const Side right = left + 2;
    // Sides in the order around the cell.
    const std::array<Side, 4> sides = {top, right, bottom, left};
    const bool a = is_below(x, y), b = is_below(x + 1, y);
    const bool c = is_below(x, y + 1), d = is_below(x + 1, y + 1);
    const std::array<bool, 4> is_crossed = {a != b, b != d, c != d, a != c};
    if (is_crossed[0] && is_crossed[1] && is_crossed[2] && is_crossed[3]) {
      // A saddle: cut off the two corners that are unlike the middle.
      const double middle = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
      const bool cuts_a = a != (middle < level_);
      join(top, cuts_a ? left : right);
      join(bottom, cuts_a ? right : left);
      return;
    }
    std::array<Side, 2> ends{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      if (is_crossed[i]) ends[count++] = sides[i];
    }
    if (count == 2) join(ends[0], ends[1]);
  }

  void join(Side a, Side b) {
    add(a, b);
    add(b, a);
  }

  void add(Side side, Side other) {
    const auto [found, is_new] = joints_.try_emplace(side);
    if (is_new) order_.push_back(side);
    found->second.others[static_cast<std::size_t>(found->second.count++)] = other;
  }

  PixelPoint point_on(Side side) const {
    const std::int64_t pixel = side / 2;
    const std::int64_t x = pixel % field_.width;
    const std::int64_t y = pixel / field_.width;
    const bool is_down = side % 2 != 0;
    const double from = field_.at(x, y);
    const double to = is_down ? field_.at(x, y + 1) : field_.at(x + 1, y);
    // Infinite samples are crossed in the middle.
    const double along = (level_ - from) / (to - from);
    const double share = std::isfinite(along) ? std::clamp(along, 0.0, 1.0) : 0.5;
    return {static_cast<double>(x) + (is_down ? 0 : share),
            static_cast<double>(y) + (is_down ? share : 0)};
  }

  Isoline follow(Side start) {
    Isoline line;
    Side side = start;
    while (true) {
      Joint& joint = joints_.at(side);
      joint.is_taken = true;
      line.push_back(point_on(side));
      int next = 0;
      while (next < joint.count &&
             joints_.at(joint.others[static_cast<std::size_t>(next)]).is_taken) {
        ++next;
      }
      if (next == joint.count) {
        const bool is_closed = line.size() > 2 && joint.count == 2 &&
                               (joint.others[0] == start || joint.others[1] == start);
        if (is_closed) line.push_back(line.front());
        return line;
      }
      side = joint.others[static_cast<std::size_t>(next)];
    }
  }

  const SectionSamples& field_;
  double level_;
  std::unordered_map<Side, Joint> joints_;
  std::vector<Side> order_;  // as they were found, so that lines come in one order
};

}  // namespace

std::vector<Isoline> isolines(const SectionSamples& field, double level) {
  return Crossings(field, level).lines();
}

std::vector<double> round_levels(double low, double high, int maximum_count) {
  std::vector<double> levels;
  if (!(high > low) || !std::isfinite(high - low) || maximum_count < 1) return levels;
  // The finest of 1, 2 and 5 times powers of ten that gives no more levels.
  const double power = std::pow(10, std::floor(std::log10((high - low) / maximum_count)));
  for (const double factor : {0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0}) {
    const double step = factor * power;
    const double first = std::floor(low / step) + 1;
    const double last = std::ceil(high / step) - 1;
    if (last - first + 1 > maximum_count) continue;
    for (double i = first; i <= last; ++i) levels.push_back(i * step);
    break;
  }
  return levels;
}

}  // namespace octavo
