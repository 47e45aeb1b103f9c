#include "octavo/ops/mask/component_parts.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <string>

#include "octavo/core/error.h"
#include "octavo/core/joined_sets.h"
#include "octavo/ops/mask/file_mask.h"

namespace octavo {

namespace {

// Rows of a plane whose labels are looked at together.
constexpr std::int64_t kRowsAtOnce = 64;

std::vector<LabelRun> runs_of_plane(const Components& found, std::int64_t z) {
  const Size3& size = found.mask().size();
  std::vector<LabelRun> runs;
  std::vector<std::uint32_t> labels;
  for (std::int64_t y = 0; y < size.y; y += kRowsAtOnce) {
    const Box rows{{0, y, z}, {size.x, std::min(size.y, y + kRowsAtOnce), z + 1}};
    labels.resize(static_cast<std::size_t>(rows.size().voxel_count()));
    found.fill_labels(rows, labels.data());
    for (std::size_t at = 0; at < labels.size();) {
      const auto row = at / static_cast<std::size_t>(size.x);
      const std::size_t row_end = (row + 1) * static_cast<std::size_t>(size.x);
      std::size_t end = at + 1;
      while (end < row_end && labels[end] == labels[at]) ++end;
      if (labels[at] != 0) {
        const auto first = static_cast<std::int64_t>(row) * size.x;
        runs.push_back({y + static_cast<std::int64_t>(row), static_cast<std::int64_t>(at) - first,
                        static_cast<std::int64_t>(end) - first, labels[at]});
      }
      at = end;
    }
  }
  return runs;
}

// How far apart along x two voxels of neighboring planes may lie that touch; -1: they never do.
std::int64_t reach_of(Connectivity connectivity, std::int64_t rows_apart) {
  switch (connectivity) {
    case Connectivity::faces: return rows_apart == 0 ? 0 : -1;
    case Connectivity::edges: return rows_apart == 0 ? 1 : 0;
    default: return 1;
  }
}

// Calls touch(label, label) for runs of two neighboring planes that touch.
template <class Touch>
void visit_touching(std::span<const LabelRun> below, std::span<const LabelRun> above,
                    Connectivity connectivity, Touch touch) {
  for (const std::int64_t step : {-1, 0, 1}) {
    const std::int64_t reach = reach_of(connectivity, std::abs(step));
    if (reach < 0) continue;
    const auto ends_before = [&](const LabelRun& a, const LabelRun& b) {
      const std::int64_t row = b.y + step;
      return a.y != row ? a.y < row : a.end + reach <= b.begin;
    };
    auto first = below.begin();
    for (const LabelRun& run : above) {
      while (first != below.end() && ends_before(*first, run)) ++first;
      for (auto at = first; at != below.end() && at->y == run.y + step &&
                            at->begin < run.end + reach; ++at) {
        touch(at->label, run.label);
      }
    }
  }
}

// A component of the whole mask.
struct Whole {
  Component component;
  ComponentSums sums;
};

void add(const Component& component, const ComponentSums& sums, Whole& to) {
  const bool is_first = to.component.voxel_count == 0;
  to.component.voxel_count += component.voxel_count;
  to.component.box =
      is_first ? component.box : united(to.component.box, component.box);
  to.sums.add(sums);
}

}  // namespace

PartOfComponents part_of_components(const Components& found, const WorkPart& part) {
  require_part(part);
  const PlanesOfPart planes = planes_of_part(found.mask().size().z, part);
  PartOfComponents result;
  result.part = part;
  result.plane_count = planes.end - planes.first;
  result.components = found.components();
  result.sums = found.sums();
  if (result.plane_count == 0) return result;
  result.first_plane = runs_of_plane(found, planes.first);
  result.last_plane = runs_of_plane(found, planes.end - 1);
  return result;
}

JoinedComponents joined_components(std::span<const PartOfComponents> parts,
                                   Connectivity connectivity, std::uint64_t most) {
  std::vector<WorkPart> numbers;
  for (const PartOfComponents& part : parts) numbers.push_back(part.part);
  const std::vector<std::size_t> places = order_of_all_parts(numbers);
  std::vector<std::size_t> first_of(places.size() + 1);  // number of its first component among all
  for (std::size_t i = 0; i < places.size(); ++i) {
    first_of[i + 1] = first_of[i] + parts[places[i]].components.size();
  }

  // Which are one
  JoinedSets<std::size_t> joined_sets(first_of.back());
  std::size_t below = places.size();  // the last part with planes
  for (std::size_t i = 0; i < places.size(); ++i) {
    const PartOfComponents& part = parts[places[i]];
    if (part.plane_count == 0) continue;
    if (below < places.size()) {
      visit_touching(parts[places[below]].last_plane, part.first_plane, connectivity,
                     [&](std::uint32_t a, std::uint32_t b) {
                       joined_sets.join(first_of[below] + a - 1, first_of[i] + b - 1);
                     });
    }
    below = i;
  }

  // What they add up to
  std::vector<std::size_t> whole_of(first_of.back());
  std::vector<Whole> wholes;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const PartOfComponents& part = parts[places[i]];
    for (std::size_t k = 0; k < part.components.size(); ++k) {
      const std::size_t own = first_of[i] + k;
      const std::size_t root = joined_sets.first_of(own);
      if (root == own) {
        if (wholes.size() == most) {
          throw Error(ErrorKind::limit_exceeded,
                      "the mask has more than " + std::to_string(most) + " components");
        }
        whole_of[own] = wholes.size();
        wholes.emplace_back();
      }
      whole_of[own] = whole_of[root];
      add(part.components[k], part.sums[k], wholes[whole_of[own]]);
    }
  }

  // Their numbers
  std::vector<std::size_t> order(wholes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    const Whole& x = wholes[a];
    const Whole& y = wholes[b];
    return x.component.voxel_count != y.component.voxel_count
               ? x.component.voxel_count > y.component.voxel_count
               : x.sums.first_code < y.sums.first_code;
  });
  JoinedComponents joined;
  std::vector<std::uint32_t> label_of(wholes.size());
  for (std::size_t place = 0; place < order.size(); ++place) {
    Whole& whole = wholes[order[place]];
    whole.component.centroid = whole.sums.centroid(whole.component.voxel_count);
    label_of[order[place]] = static_cast<std::uint32_t>(place + 1);
    joined.components.push_back(whole.component);
  }
  joined.labels.resize(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t own = first_of[i]; own < first_of[i + 1]; ++own) {
      joined.labels[i].push_back(label_of[whole_of[own]]);
    }
  }
  return joined;
}

}  // namespace octavo
