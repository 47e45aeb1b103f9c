// What describes a volume, between Python's order z, y, x and the library's x, y, z.
#pragma once

#include <nanobind/nanobind.h>

#include <array>
#include <cstdint>
#include <string>

#include "octavo/core/volume.h"
#include "octavo/io/source/stored_type.h"
#include "octavo/tasks/result_facts.h"

namespace octavo::python {

/// Numbers along z, y, x, as Python has shapes.
using Zyx = std::array<std::int64_t, 3>;

inline Zyx zyx_of(const Size3& size) { return {size.z, size.y, size.x}; }
inline Zyx zyx_of(const Index3& index) { return {index.z, index.y, index.x}; }
inline Size3 size_of(const Zyx& shape) { return {shape[2], shape[1], shape[0]}; }
inline Index3 index_of(const Zyx& index) { return {index[2], index[1], index[0]}; }

inline Point3 xyz_of(const std::array<double, 3>& zyx) { return {zyx[2], zyx[1], zyx[0]}; }
inline nanobind::tuple zyx_of(const Point3& point) {
  return nanobind::make_tuple(point[2], point[1], point[0]);
}

/// What `of` says of each one of `all`.
template <class All, class Of>
nanobind::list list_of(const All& all, Of of) {
  nanobind::list list;
  for (const auto& one : all) list.append(of(one));
  return list;
}

/// What a task found.
nanobind::object object_of(const FactValue& value);
nanobind::dict dict_of(const Facts& facts);

/// What files and maps say alike: dtype, direction, is_spacing_known, metadata, label_names.
nanobind::dict volume_facts(const VolumeDescription& volume);

/// What the planes that Python gives are of: facts["dtype"].
/// Throws Error{invalid_argument} where no voxels can be made of it
StoredType given_type(const nanobind::dict& facts);

/// The description of a volume that Python gives planes of; its type is that which wide numbers
/// become unless their values ask for another.
/// shape  z, y, x
/// facts  dtype, kind, spacing (z, y, x) or None, origin (z, y, x), direction (9 numbers,
///        row-major, columns x, y, z), slope, intercept, unit or None, label_names (label: name) or
///        None, source_metadata (of what the planes are read from, whose names of labels are kept
///        where none are given) or None, format
/// Throws as given_type, require_labels_to_name and set_label_names; Error{invalid_argument} for
///        what is no label or no name
VolumeDescription description_of(const Zyx& shape, const nanobind::dict& facts);

}  // namespace octavo::python
