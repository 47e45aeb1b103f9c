// The header of a NRRD file: its fields, as text.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "octavo/io/source/header_text.h"
#include "octavo/io/source/source_identity.h"

namespace octavo {

/// The fields of a header and where the empty line behind it ends. Names are in lower case, in one
/// of their spellings ("axis mins", "byte skip", "centers", "data file", "line skip"). A key of
/// "key:=value" keeps its ":=", so that it is never taken for a field.
class NrrdHeader {
 public:
  /// Reads the header of `path`. Throws Error{source_rejected} when it is none, Error{io}.
  explicit NrrdHeader(const std::string& path);

  const std::string& path() const { return path_; }
  std::uint64_t data_offset() const { return data_offset_; }
  bool has(const std::string& name) const { return fields_.contains(name); }
  /// A field; an empty value when there is none of this name.
  FieldText field(const std::string& name) const;
  /// Whether "data file" is LIST, and names stand behind it.
  bool names_list() const;
  std::string text(const std::string& name) const { return std::string(field(name).value); }
  /// The lines behind "data file: LIST", which end the header.
  std::string_view file_list() const { return file_list_; }
  /// What says nothing of the voxels.
  const SourceIdentity& identity() const { return identity_; }

 private:
  void take_line(std::string_view line);

  std::string path_;
  SourceIdentity identity_;
  std::map<std::string, std::string> fields_;
  std::string file_list_;
  std::uint64_t data_offset_ = 0;
};

}  // namespace octavo
