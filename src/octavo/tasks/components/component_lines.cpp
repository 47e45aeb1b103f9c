#include "octavo/tasks/components/component_lines.h"

#include <algorithm>
#include <limits>
#include <string>

#include "octavo/core/error.h"
#include "octavo/ops/mask/file_mask.h"
#include "octavo/tasks/files/part_result.h"

namespace octavo {

namespace {

// Readers take twice as many values in a line; whole components and whole runs fit.
constexpr std::size_t kNumbersOfLine = 28 * 1024;
constexpr std::size_t kNumbersOfComponent = 14;
constexpr std::size_t kNumbersOfRun = 4;

constexpr const char* kComponentList = "components";
constexpr const char* kFirstPlane = "first plane";
constexpr const char* kLastPlane = "last plane";
constexpr const char* kLabelList = "labels of part";

[[noreturn]] void fail_lines(const std::string& what) {
  throw Error(ErrorKind::corrupt,
              "no result of a part, or damaged: " + what + "; make it anew");
}

void append_lists(const char* of, std::span<const std::int64_t> all,
                  std::vector<JsonObject>& lines) {
  for (std::size_t at = 0; at < all.size(); at += kNumbersOfLine) {
    const auto here = all.subspan(at, std::min(kNumbersOfLine, all.size() - at));
    lines.push_back(JsonObject()
                        .set("of", of)
                        .set("numbers", std::vector<std::size_t>{here.size()})
                        .set("all", here));
  }
}

/// The numbers of a line that append_lists wrote.
std::vector<std::int64_t> list_of(const JsonObject& line) {
  const std::int64_t count = integers_in(line, "numbers", 1).front();
  if (count < 0 || count > static_cast<std::int64_t>(kNumbersOfLine)) fail_lines("a long list");
  return integers_in(line, "all", static_cast<std::size_t>(count));
}

// --- One component: voxels, box, first code, and each doubled sum in two halves

void append_component(const Component& component, const ComponentSums& sums,
                      std::vector<std::int64_t>& numbers) {
  const Box& box = component.box;
  numbers.insert(numbers.end(),
                 {static_cast<std::int64_t>(component.voxel_count), box.lo.x, box.lo.y, box.lo.z,
                  box.hi.x, box.hi.y, box.hi.z, static_cast<std::int64_t>(sums.first_code)});
  for (const __int128 doubled : sums.doubled) {
    numbers.push_back(static_cast<std::int64_t>(doubled >> 32));
    numbers.push_back(static_cast<std::int64_t>(doubled & 0xffffffff));
  }
}

void take_component(std::span<const std::int64_t> n, const Box& planes, PartOfComponents& found) {
  Component component;
  component.voxel_count = static_cast<std::uint64_t>(n[0]);
  component.box = {{n[1], n[2], n[3]}, {n[4], n[5], n[6]}};
  const Box& box = component.box;
  const bool is_within = !box.is_empty() && intersection(box, planes) == box;
  if (!is_within || n[0] < 1 || n[0] > box.size().voxel_count() || n[7] < 0) {
    fail_lines("a component that does not lie in its planes");
  }
  ComponentSums sums;
  sums.first_code = static_cast<std::uint64_t>(n[7]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t high = n[8 + 2 * axis];
    const std::int64_t low = n[9 + 2 * axis];
    constexpr std::int64_t kMostHigh = std::int64_t{1} << 40;  // so that all parts may be added up
    const bool is_sum = high >= 0 && high < kMostHigh && low >= 0 && low <= 0xffffffff;
    if (!is_sum) fail_lines("a sum that is none");
    sums.doubled[axis] = static_cast<__int128>(high) * (std::int64_t{1} << 32) + low;
  }
  found.components.push_back(component);
  found.sums.push_back(sums);
}

// --- Runs

std::vector<std::int64_t> numbers_of_runs(const std::vector<LabelRun>& runs) {
  std::vector<std::int64_t> numbers;
  numbers.reserve(kNumbersOfRun * runs.size());
  for (const LabelRun& run : runs) {
    numbers.insert(numbers.end(), {run.y, run.begin, run.end, std::int64_t{run.label}});
  }
  return numbers;
}

/// Appends a run that lies behind those before it.
void take_run(std::span<const std::int64_t> n, const Size3& size, std::int64_t labels,
              std::vector<LabelRun>& runs) {
  const bool is_within = n[0] >= 0 && n[0] < size.y && n[1] >= 0 && n[1] < n[2] && n[2] <= size.x;
  const bool follows = runs.empty() || runs.back().y < n[0] ||
                       (runs.back().y == n[0] && runs.back().end <= n[1]);
  if (!is_within || !follows || n[3] < 1 || n[3] > labels) fail_lines("a run that is none");
  runs.push_back({n[0], n[1], n[2], static_cast<std::uint32_t>(n[3])});
}

/// Calls take(numbers) for each `step` numbers of a line.
template <class Take>
void take_each(const JsonObject& line, std::size_t step, Take take) {
  const std::vector<std::int64_t> numbers = list_of(line);
  if (numbers.size() % step != 0) fail_lines("a list that ends too soon");
  for (std::size_t at = 0; at < numbers.size(); at += step) {
    take(std::span(numbers).subspan(at, step));
  }
}

}  // namespace

std::vector<JsonObject> lines_of_components(const PartOfComponents& found) {
  std::vector<JsonObject> lines(1);
  lines.front().set("planes", std::vector<std::int64_t>{found.plane_count});
  lines.front().set("counts",
                    std::vector<std::size_t>{found.components.size(), found.first_plane.size(),
                                             found.last_plane.size()});
  constexpr std::size_t kAtOnce = kNumbersOfLine / kNumbersOfComponent;
  for (std::size_t first = 0; first < found.components.size(); first += kAtOnce) {
    std::vector<std::int64_t> numbers;
    for (std::size_t i = first; i < std::min(first + kAtOnce, found.components.size()); ++i) {
      append_component(found.components[i], found.sums[i], numbers);
    }
    append_lists(kComponentList, numbers, lines);
  }
  append_lists(kFirstPlane, numbers_of_runs(found.first_plane), lines);
  append_lists(kLastPlane, numbers_of_runs(found.last_plane), lines);
  return lines;
}

PartOfComponents components_of_lines(std::span<const JsonObject> lines, const WorkPart& part,
                                     const Size3& size) {
  const JsonObject head = lines.empty() ? JsonObject() : lines.front();
  const auto counts = integers_in(head, "counts", 3);
  const PlanesOfPart planes = planes_of_part(size.z, part);
  PartOfComponents found;
  found.part = part;
  found.plane_count = planes.end - planes.first;
  const bool is_count = counts[0] <= std::numeric_limits<std::uint32_t>::max();
  if (integers_in(head, "planes", 1).front() != found.plane_count || !is_count) {
    fail_lines("other planes than those of its part");
  }
  const Box box{{0, 0, planes.first}, {size.x, size.y, planes.end}};
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::string of = text_in(lines[i], "of");
    if (of == kComponentList) {
      take_each(lines[i], kNumbersOfComponent,
                [&](auto numbers) { take_component(numbers, box, found); });
    } else {
      if (of != kFirstPlane && of != kLastPlane) fail_lines("a list of something else");
      std::vector<LabelRun>& runs = of == kFirstPlane ? found.first_plane : found.last_plane;
      take_each(lines[i], kNumbersOfRun,
                [&](auto numbers) { take_run(numbers, size, counts[0], runs); });
    }
  }
  const auto is_full = [](const auto& list, std::int64_t count) {
    return static_cast<std::int64_t>(list.size()) == count;
  };
  if (!is_full(found.components, counts[0]) || !is_full(found.first_plane, counts[1]) ||
      !is_full(found.last_plane, counts[2])) {
    fail_lines("other counts than it holds");
  }
  return found;
}

std::vector<JsonObject> lines_of_labels(const LabelsOfParts& labels) {
  std::vector<JsonObject> lines;
  for (const std::vector<std::uint32_t>& of_part : labels) {
    lines.push_back(JsonObject().set(kLabelList, std::vector<std::size_t>{of_part.size()}));
    for (std::size_t at = 0; at < of_part.size(); at += kNumbersOfLine) {
      const std::size_t end = std::min(at + kNumbersOfLine, of_part.size());
      const std::vector<std::int64_t> numbers(
          of_part.begin() + static_cast<std::ptrdiff_t>(at),
          of_part.begin() + static_cast<std::ptrdiff_t>(end));
      append_lists(kLabelList, numbers, lines);
    }
  }
  return lines;
}

LabelsOfParts labels_of_lines(std::span<const JsonObject> lines, std::int64_t part_count,
                              std::size_t most) {
  LabelsOfParts labels;
  std::vector<std::int64_t> counts;
  for (const JsonObject& line : lines) {
    if (!line.json_of(kLabelList).empty()) {
      counts.push_back(integers_in(line, kLabelList, 1).front());
      labels.emplace_back();
      continue;
    }
    if (labels.empty()) fail_lines("labels of no part");
    for (const std::int64_t label : list_of(line)) {
      if (label < 0 || static_cast<std::uint64_t>(label) > most) fail_lines("a label too high");
      labels.back().push_back(static_cast<std::uint32_t>(label));
    }
  }
  bool is_full = static_cast<std::int64_t>(labels.size()) == part_count;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    is_full = is_full && static_cast<std::int64_t>(labels[i].size()) == counts[i];
  }
  if (!is_full) fail_lines("other counts than it holds");
  return labels;
}

}  // namespace octavo
