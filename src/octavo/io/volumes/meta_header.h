// The header of a MetaImage file: its fields, as text.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>

#include "octavo/io/source/data_files.h"
#include "octavo/io/source/header_text.h"
#include "octavo/io/source/source_identity.h"

namespace octavo {

/// The fields of a header up to ElementDataFile, and where the bytes behind it start. A field of
/// the format that is there twice says the same both times.
class MetaHeader {
 public:
  /// Reads the header of `path`. Throws Error{source_rejected} when it is none, or has a field of
  /// the format twice with different values; Error{io}.
  explicit MetaHeader(const std::string& path);

  const std::string& path() const { return path_; }
  std::uint64_t data_offset() const { return data_offset_; }
  bool has(const std::string& name) const { return fields_.contains(name); }
  std::string text(const std::string& name) const {
    return std::string(field({name.c_str()}).value);
  }
  /// The first of several fields that is there; an empty value when none is.
  FieldText field(std::initializer_list<const char*> names) const;
  /// So does this of spellings of one field.
  /// Throws Error{source_rejected} naming two that contradict each other
  FieldText agreed_field(std::initializer_list<const char*> spellings) const;
  /// What the first of several spellings that is there says; false when none is.
  /// Throws Error{source_rejected} for a word that is neither True nor False, and as agreed_field
  bool is_true(std::initializer_list<const char*> spellings) const;
  /// The names behind "ElementDataFile = LIST". Throws Error{source_rejected} above 1 MiB
  DataFileNames file_list() const;
  /// What says nothing of the voxels.
  SourceIdentity identity() const;

 private:
  void take_field(const std::string& name, std::string_view value);
  bool says_true(const FieldText& field) const;

  std::string path_;
  std::map<std::string, std::string> fields_;
  std::uint64_t data_offset_ = 0;
};

}  // namespace octavo
