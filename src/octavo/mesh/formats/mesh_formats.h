// The formats one by one; mesh_file.h chooses among them.
//
// Each appends a mesh to a file, in mm, and throws as PendingFile, Error{cancelled}, and
// Error{limit_exceeded} where it has more points or triangles than the format can number.
#pragma once

#include "octavo/core/progress.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/mesh/formats/mesh_description.h"

namespace octavo {

/// Binary: corners and normals of triangles, and the space in the header.
void write_stl(const MeshDescription& mesh, const Progress& watcher, PendingFile& file);

/// Binary: points with their normals, triangles with the label of their part, or with a pair of
/// labels.
void write_ply(const MeshDescription& mesh, const Progress& watcher, PendingFile& file);

/// Text: points with their normals, an object of triangles for each part, with a name that no other
/// one has, or a group for each pair of labels.
void write_obj(const MeshDescription& mesh, const Progress& watcher, PendingFile& file);

/// XML of VTK with raw arrays behind it: points with their normals, triangles with the label of
/// their part, or with a pair of labels.
void write_vtp(const MeshDescription& mesh, const Progress& watcher, PendingFile& file);

/// Zipped XML for printers: an object with a name and a color for each part, all moved together to
/// where no coordinate is negative. Minizip compresses it.
void write_three_mf(const MeshDescription& mesh, const Progress& watcher, PendingFile& file);

/// glTF 2.0, compressed by meshoptimizer: a node with a name and a color for each part, under one
/// that turns mm in LPS into meters with y up and z to the front. The space that is described does
/// not matter.
void write_glb(const MeshDescription& mesh, const Progress& watcher, PendingFile& file);

}  // namespace octavo
