#include "facts.h"

#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

#include <map>
#include <optional>
#include <string>

#include "asked.h"
#include "octavo/core/error.h"
#include "octavo/core/given_label.h"
#include "octavo/tasks/files/named_labels.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo::python {

namespace nb = nanobind;

namespace {

LabelNames given_names(const std::map<std::int64_t, std::string>& given) {
  LabelNames names;
  for (const auto& [label, name] : given) {
    if (!is_label(label)) {
      throw Error(ErrorKind::invalid_argument,
                  std::to_string(label) + " is no label: expected a whole number of at most 32 "
                                          "bits");
    }
    const std::string fault = label_name_fault(name);
    if (!fault.empty()) {
      throw Error(ErrorKind::invalid_argument,
                  "the name of label " + std::to_string(label) + " " + fault);
    }
    names.set(label, {name, {}});
  }
  return names;
}

/// Names that are given, else those of the labels that the planes were read from.
LabelNames names_of(const nb::dict& facts, VolumeKind kind) {
  using Given = std::optional<std::map<std::int64_t, std::string>>;
  if (const auto given = asked_for<Given>(facts, "label_names")) {
    if (!given->empty()) require_labels_to_name(kind, "");
    return given_names(*given);
  }
  const auto source = asked_for<std::optional<nb::bytes>>(facts, "source_metadata");
  if (!source || kind == VolumeKind::grey) return {};
  return Metadata::read(std::string(source->c_str(), source->size())).facts().labels;
}

}  // namespace

nb::object object_of(const FactValue& value) {
  return std::visit(
      []<class Held>(const Held& held) -> nb::object {
        if constexpr (std::is_same_v<Held, std::monostate>) {
          return nb::none();
        } else if constexpr (std::is_same_v<Held, Facts>) {
          return dict_of(held);
        } else if constexpr (std::is_same_v<Held, FactValue::List>) {
          return list_of(held, object_of);
        } else {
          return nb::cast(held);
        }
      },
      value.held());
}

nb::dict dict_of(const Facts& facts) {
  nb::dict dict;
  for (const Fact& fact : facts) dict[fact.name.c_str()] = object_of(fact.value);
  return dict;
}

nb::dict volume_facts(const VolumeDescription& volume) {
  nb::dict names;
  for (const auto& [label, name] : volume.metadata.facts().labels.all()) {
    names[nb::int_(label)] = name.name;
  }
  nb::dict facts;
  facts["dtype"] = voxel_type_name(volume.type);
  facts["direction"] = volume.geometry.direction;
  facts["is_spacing_known"] = volume.metadata.is_spacing_known();
  facts["metadata"] = nb::bytes(volume.metadata.text().data(), volume.metadata.text().size());
  facts["label_names"] = names;
  return facts;
}

StoredType given_type(const nb::dict& facts) {
  const auto dtype = asked_for<std::string>(facts, "dtype");
  if (const std::optional<StoredType> type = parse_stored_type(dtype)) return *type;
  throw Error(ErrorKind::invalid_argument,
              "voxels of type " + dtype + " have no place in a file: int8, uint8, int16, uint16, "
              "int32, uint32 and float32 do; of int64, uint64 and float64 what fits these")
      .with_field("dtype");
}

VolumeDescription description_of(const Zyx& shape, const nb::dict& facts) {
  VolumeDescription volume;
  MetadataFacts noted;
  volume.type = given_type(facts).voxel();
  volume.kind = asked_word<VolumeKind>(facts, "kind");
  volume.size = size_of(shape);
  const auto spacing = asked_for<std::optional<std::array<double, 3>>>(facts, "spacing");
  if (spacing) volume.geometry.spacing_mm = xyz_of(*spacing);
  noted.spacing_known = spacing.has_value();
  noted.spacing_source = spacing ? "user" : "assumed";
  volume.geometry.origin_mm = xyz_of(asked_for<std::array<double, 3>>(facts, "origin"));
  volume.geometry.direction = asked_for<std::array<double, 9>>(facts, "direction");
  if (!is_valid(volume.geometry)) {
    throw Error(ErrorKind::invalid_argument,
                "spacing, origin and direction are no geometry: spacings lie within 1e-9 to 1e9 "
                "mm, and no axis follows from the others").with_field("spacing_mm");
  }
  volume.rescale = {asked_for<double>(facts, "slope"), asked_for<double>(facts, "intercept")};
  if (!is_valid(volume.rescale, volume.type)) {
    throw Error(ErrorKind::invalid_argument,
                "the slope is 0, or real values are not finite").with_field("rescale");
  }
  noted.unit = asked_for<std::optional<std::string>>(facts, "unit");
  noted.source.emplace().format = asked_for<std::string>(facts, "format");
  volume.metadata = Metadata::of(std::move(noted));
  if (const LabelNames names = names_of(facts, volume.kind); !names.is_empty()) {
    set_label_names(volume.metadata, names);
  }
  return volume;
}

}  // namespace octavo::python
