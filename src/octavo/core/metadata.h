// The metadata of a volume: the JSON text that stands in a file, and what it says.
//
// The text decides. What it says is read once, typed and within limits (json_reader.h); every
// change writes a new text and reads that. Members that this program does not know, and all others
// that a change does not concern, keep their text and their place. A text that cannot be read is
// kept as it is and says nothing: opening such a file is no error.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "octavo/core/metadata_facts.h"

namespace octavo {

class Metadata {
 public:
  /// An object without members.
  Metadata() = default;
  /// What `text` says; nothing where it is no JSON object in UTF-8 within the limits.
  static Metadata read(std::string text);
  /// New metadata of these facts.
  static Metadata of(MetadataFacts facts);

  /// The text, byte for byte as it was read unless it was changed.
  const std::string& text() const { return text_; }
  const MetadataFacts& facts() const { return facts_; }
  bool is_readable() const { return defect_.empty(); }
  /// Why the text cannot be read; empty where it can.
  const std::string& defect() const { return defect_; }

  /// Whether there are texts that may tell who, where or when.
  bool keeps_identity() const {
    return facts_.identity && facts_.identity->attributes && !facts_.identity->attributes->empty();
  }
  /// False when the source carried no spacing and 1 mm was assumed.
  bool is_spacing_known() const { return facts_.spacing_known.value_or(true); }
  /// A code of UCUM, or any text, as it stands there; empty where none does.
  std::string unit() const { return facts_.unit.value_or(""); }
  /// How far the source of a file lay from its own source, real units; 0 when nothing is known.
  double source_max_error() const { return facts_.source_max_error.value_or(0); }
  /// True when the source had lost something before it came here.
  bool was_source_lossy() const {
    return facts_.lossy_source.value_or(false) || source_max_error() > 0;
  }

  // Each of these puts a member behind the others, in place of the one that was there. Text that
  // cannot be read stays as it is.
  void set_coding(const CodingNote& coding);
  void set_labels(const LabelNames& labels);
  void set_made_by(const MadeBy& made_by);
  void set_place_known(bool is_known);
  void set_repaired(const RepairNote& repaired);
  void set_spacing(bool is_known, const std::string& source);
  /// Is left out where the text has no room for it.
  void set_written_by(const WriterNote& writer);
  void drop_labels();

  /// Notes planes made between slices and puts all members in the order of their names.
  /// made_planes  of those, the ones made of planes that were no slices; nothing: is not said
  /// missing      the ones made of planes that an interrupted build lacked, if any
  void set_isotropic(const IsotropicNote& isotropic,
                     const std::optional<std::vector<PlaneRun>>& made_planes,
                     const std::optional<PlaneRun>& missing);

  /// Without what may tell who, where or when: the texts of an identity, of which the names stay as
  /// what was dropped, and text that cannot be read. All that leaves a file takes this way.
  Metadata without_identity() const;

  /// For labels computed from the volume: without what is said of values, of people and of the
  /// names of labels.
  Metadata for_labels(const MadeBy& made_by) const;

  /// For a file built from the one that these stand in: how that was coded is over, what it lost is
  /// not.
  /// lost           how far its voxels lay from their source, real units
  /// keep_identity  whether what was kept of the identity of the source is passed on
  Metadata for_copy(double lost, bool keep_identity) const;

  bool operator==(const Metadata& other) const { return text_ == other.text_; }

 private:
  /// All members in normal form (json_members.h). Text that cannot be read becomes one of them.
  JsonObject normal_members() const;
  /// The same without_identity.
  JsonObject members_without_identity() const;
  void put_behind(MetadataFacts facts);

  std::string text_ = "{}";
  MetadataFacts facts_;
  std::string defect_;
};

}  // namespace octavo
