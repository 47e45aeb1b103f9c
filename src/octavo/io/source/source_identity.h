// What a source says that may tell who, where or when: names, dates, identifiers, free text.
//
// By default none of it enters a file: the metadata only list the names of what was dropped, and
// how often it was there. A name is that of the format ("PatientName", "descrip"), never one that
// somebody chose: those may tell as much as a value, and are counted together.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "octavo/core/metadata_facts.h"

namespace octavo {

class SourceIdentity {
 public:
  /// Notes a text that could be kept; empty ones are nothing. Several under one name become lines
  /// of one text, each once; those that would make it longer than 64 KiB are not kept.
  void note(const std::string& name, std::string value);

  /// Notes `count` values that are not kept even if that is asked for.
  void note_lost(const std::string& name, std::int64_t count = 1);

  bool is_empty() const { return counts_.empty(); }

  /// For the metadata. Where texts are kept, all values of a name that is kept count as kept.
  IdentityNote note_for_file(bool keep) const;

 private:
  std::map<std::string, std::string> values_;
  std::map<std::string, std::set<std::string>> noted_;  ///< texts that stand in those of values_
  std::map<std::string, std::int64_t> counts_;  ///< of all names
};

}  // namespace octavo
