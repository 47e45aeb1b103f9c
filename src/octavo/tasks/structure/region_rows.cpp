#include "octavo/tasks/structure/region_rows.h"

#include <array>
#include <optional>
#include <sstream>
#include <variant>

#include "octavo/core/text.h"

namespace octavo {

namespace {

constexpr const char* kCentroidColumns = "centroid_[x y z]_mm";
constexpr const char* kBoxColumns = "box_[x y z]_[lo hi]";

std::array<std::array<std::int64_t, 2>, 3> ends_of(const Box& box) {
  return {{{box.lo.x, box.hi.x}, {box.lo.y, box.hi.y}, {box.lo.z, box.hi.z}}};
}

template <class Of, class T>
std::optional<T> member_if(const std::optional<Of>& of, T Of::* member) {
  return of ? std::optional<T>((*of).*member) : std::nullopt;
}

/// Named alike in objects and tables.
RegionField field(const std::string& name, const FactValue& value) { return {{name, value}, name}; }

void append_grey(const GreyStatistics& grey, const std::optional<RegionInMm>& in_mm,
                 const std::vector<double>& percents, RegionRow& row) {
  row.insert(row.end(),
             {field("mean", grey.mean), field("sd", grey.deviation), field("min", grey.minimum),
              field("max", grey.maximum),
              field("integrated_mm3", in_mm ? in_mm->integrated : std::nullopt)});
  if (percents.empty()) return;
  Facts of_percent;
  std::string names;
  for (std::size_t i = 0; i < percents.size(); ++i) {
    const std::string percent = exact_text(percents[i]);
    of_percent.push_back({percent, grey.percentiles[i]});
    names += (i == 0 ? "" : " ") + percent;
  }
  row.push_back({{"percentiles", of_percent}, "p[" + names + "]"});
}

std::vector<std::string> column_names(const std::string& pattern) {
  const std::size_t open = pattern.find('[');
  if (open == std::string::npos) return {pattern};
  const std::size_t close = pattern.find(']', open);
  std::vector<std::string> names;
  std::istringstream words(pattern.substr(open + 1, close - open - 1));
  for (std::string word; words >> word;) {
    const auto of_word =
        column_names(pattern.substr(0, open) + word + pattern.substr(close + 1));
    names.insert(names.end(), of_word.begin(), of_word.end());
  }
  return names;
}

/// The single values of lists and objects, in their order.
void append_single_values(const FactValue& value, std::vector<FactValue>& all) {
  if (const auto* const list = std::get_if<FactValue::List>(&value.held())) {
    for (const FactValue& one : *list) append_single_values(one, all);
  } else if (const auto* const facts = std::get_if<Facts>(&value.held())) {
    for (const Fact& one : *facts) append_single_values(one.value, all);
  } else {
    all.push_back(value);
  }
}

}  // namespace

RegionRow region_row(const MeasuredRegion& measured, const MeasureResult& result) {
  const RegionMeasure& region = measured.region;
  const std::optional<RegionInMm>& in_mm = measured.in_mm;
  const std::string& name = result.names.name_of(region.label);
  const std::optional<PrincipalAxes> principal = member_if(in_mm, &RegionInMm::axes);
  RegionRow row = {
      field("label", region.label),
      field("name", name),
      field("voxels", region.voxel_count),
      field("mm3", member_if(in_mm, &RegionInMm::mm3)),
      field("surface_voxels", region.surface_voxel_count),
      {{"centroid_mm", member_if(in_mm, &RegionInMm::centroid)}, kCentroidColumns},
      {{"centroid_voxel", region.centroid}, "centroid_[x y z]_voxel"},
      {{"box", ends_of(region.box)}, kBoxColumns},
      {{"principal_moments_mm2", member_if(principal, &PrincipalAxes::moments_mm2)},
       "principal_moment_[1 2 3]_mm2"},
      {{"principal_axes", member_if(principal, &PrincipalAxes::axes)},
       "principal_axis_[1 2 3]_[x y z]"}};
  if (region.grey) append_grey(*region.grey, in_mm, result.percentiles, row);
  return row;
}

RegionRow region_row(const ComponentRow& component) {
  return {field("label", component.label), field("voxels", component.voxels),
          field("mm3", component.mm3),
          {{"centroid_mm", component.centroid_mm}, kCentroidColumns},
          {{"box", ends_of(component.box)}, kBoxColumns}};
}

Facts facts_of(const RegionRow& row) {
  Facts facts;
  for (const RegionField& one : row) facts.push_back(one.fact);
  return facts;
}

Facts columns_of(const RegionRow& row) {
  Facts columns;
  for (const RegionField& one : row) {
    std::vector<FactValue> values;
    append_single_values(one.fact.value, values);
    const std::vector<std::string> names = column_names(one.columns);
    values.resize(names.size());  // one is nothing where nothing is known
    for (std::size_t i = 0; i < names.size(); ++i) columns.push_back({names[i], values[i]});
  }
  return columns;
}

}  // namespace octavo
