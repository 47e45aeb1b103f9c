// Metadata of arbitrary bytes: whatever is read keeps its text and the limits, says the same when
// it is written again, and takes every change; whatever is not read stays as it is.
#include <algorithm>
#include <functional>
#include <string>
#include <string_view>

#include "fuzz/fuzz_target.h"
#include "octavo/core/json_reader.h"
#include "octavo/core/metadata.h"

namespace {

using namespace octavo;
using fuzz::require;

constexpr std::size_t kMaxTextBytes = 160 << 10;
constexpr std::uint8_t kPowers = 18;

/// Bytes that begin with a power of two below kPowers give a text in which a part is repeated so
/// often, less a few times, so that short inputs reach all limits. Others are a text.
std::string take_text(fuzz::Input& input, bool is_plain) {
  const auto text_of = [](const std::vector<std::uint8_t>& bytes) {
    return std::string(bytes.begin(), bytes.end());
  };
  if (is_plain) return text_of(input.take_bytes(input.left()));
  const auto count = std::size_t{1} << input.take<std::uint8_t>();
  const auto fewer = input.take<std::uint8_t>();
  std::string text = text_of(input.take_bytes(input.take<std::uint8_t>()));
  const std::string part = text_of(input.take_bytes(input.take<std::uint8_t>()));
  const std::size_t times = count - std::min<std::size_t>(count, fewer % 4);
  for (std::size_t i = 0; i < times && text.size() < kMaxTextBytes; ++i) text += part;
  return text + text_of(input.take_bytes(input.left()));
}

/// What a text holds, counted without the reader. Requires JSON.
struct Extent {
  int depth = 0;
  std::size_t values = 0;
  std::size_t longest_string = 0;  // as it is written
};

Extent extent_of(std::string_view json) {
  Extent extent;
  int depth = 0;
  std::size_t commas = 0;
  std::size_t empty = 0;  // objects and lists
  std::size_t open = 0;   // objects and lists in all
  char before = 0;        // no blank, no text of a string
  for (std::size_t at = 0; at < json.size(); ++at) {
    const char c = json[at];
    if (c == '"') {
      const std::size_t begin = ++at;
      for (; json[at] != '"'; ++at) at += json[at] == '\\' ? 1u : 0u;
      extent.longest_string = std::max(extent.longest_string, at - begin);
    } else if (c == '{' || c == '[') {
      extent.depth = std::max(extent.depth, ++depth);
      ++open;
    } else if (c == '}' || c == ']') {
      --depth;
      empty += before == '{' || before == '[' ? 1 : 0;
    } else if (c == ',') {
      ++commas;
    }
    if (c != ' ' && c != '\t' && c != '\n' && c != '\r') before = c;
  }
  // Each list of n > 0 members has n - 1 commas.
  extent.values = 1 + commas + open - empty;
  return extent;
}

/// An escape of six bytes is a character of at least one.
void require_limits(const Metadata& metadata) {
  if (!metadata.is_readable()) return;
  const Extent extent = extent_of(metadata.text());
  require(extent.depth <= kMaxJsonDepth, "deeper than the limit");
  require(extent.values <= kMaxJsonValues, "more values than the limit");
  require(extent.longest_string <= 6 * kMaxJsonStringBytes, "a longer string than the limit");
  require(metadata.facts().labels.size() <= LabelNames::kMaxLabels, "more labels than the limit");
}

/// Whether a text of so much more than `metadata` may go beyond the limits.
bool may_be_full(const Metadata& metadata) {
  const Extent extent = extent_of(metadata.text());
  return extent.values + LabelNames::kMaxLabels > kMaxJsonValues ||
         extent.depth + 2 > kMaxJsonDepth;
}

std::string text_of_facts(MetadataFacts facts) { return Metadata::of(std::move(facts)).text(); }

/// Facts written and read say the same.
void check_facts(const Metadata& metadata) {
  const Metadata again = Metadata::of(metadata.facts());
  if (!again.is_readable() && may_be_full(metadata)) return;
  require(again.is_readable(), "its own facts cannot be read");
  require_limits(again);
  require(again.facts().labels == metadata.facts().labels, "other labels");
  require(text_of_facts(again.facts()) == again.text(), "facts change when they are read again");
}

/// A change of metadata and how it shows in the facts.
struct Change {
  std::function<void(Metadata&)> make;
  std::function<void(MetadataFacts&)> note;
};

LabelNames two_names() {
  LabelNames names;
  names.set(1, {"left \"lung\"", LabelColor{255, 128, 0}});
  names.set(-7, {"\xc2\xb5", {}});
  return names;
}

CodingNote coding_note() {
  CodingNote note;
  note.preset = "fast";
  note.max_error = 2.5;
  note.nan = -1000;
  return note;
}

const Change kChanges[] = {
    {[](Metadata& m) { m.set_coding(coding_note()); },
     [](MetadataFacts& f) { f.coding = coding_note(); }},
    {[](Metadata& m) { m.set_labels(two_names()); },
     [](MetadataFacts& f) { f.labels = two_names(); }},
    {[](Metadata& m) { m.set_made_by(MadeBy("union").set("connectivity", 6)); },
     [](MetadataFacts& f) { f.made_by = MadeBy("union").set("connectivity", 6); }},
    {[](Metadata& m) { m.set_place_known(false); },
     [](MetadataFacts& f) { f.place_known = false; }},
    {[](Metadata& m) { m.set_repaired({PlaneRun{3, 9}, -1024}); },
     [](MetadataFacts& f) { f.repaired = RepairNote{PlaneRun{3, 9}, -1024}; }},
    {[](Metadata& m) { m.set_spacing(true, "user"); },
     [](MetadataFacts& f) {
       f.spacing_known = true;
       f.spacing_source = "user";
     }},
    {[](Metadata& m) { m.drop_labels(); }, [](MetadataFacts& f) { f.labels = {}; }},
};

/// Every change is made and changes nothing else.
void check_changes(const Metadata& metadata) {
  for (const Change& change : kChanges) {
    Metadata changed = metadata;
    change.make(changed);
    if (!metadata.is_readable()) {
      require(changed.text() == metadata.text(), "a text that cannot be read was changed");
      continue;
    }
    require_limits(changed);
    if (!changed.is_readable() && may_be_full(metadata)) continue;
    require(changed.is_readable(), "cannot be read once it was changed");
    MetadataFacts facts = metadata.facts();
    change.note(facts);
    require(text_of_facts(changed.facts()) == text_of_facts(facts), "a change changed other facts");
  }
}

/// Metadata of other volumes made from this one can be read, whatever it was.
void check_others(const Metadata& metadata) {
  const bool may_fail = metadata.is_readable() && may_be_full(metadata);
  const Metadata labels = metadata.for_labels(MadeBy("threshold"));
  require(labels.is_readable() || may_fail, "those for labels cannot be read");
  require_limits(labels);
  require(labels.facts().labels.is_empty() || !labels.is_readable(), "names of other labels stay");
  for (const double lost : {0.0, 0.25}) {
    const Metadata copy = metadata.for_copy(lost, false);
    require_limits(copy);
    require(copy.text() == metadata.text() || copy.is_readable() || may_fail,
            "those for a copy cannot be read");
    require(!copy.is_readable() || copy.source_max_error() >= lost, "what was lost is forgotten");
  }
  Metadata between = metadata;
  between.set_isotropic({1.5, 9, "linear", 3, 10, 0.5}, {}, PlaneRun{1, 2});
  require(between.is_readable() || may_fail, "those of planes in between cannot be read");
  require_limits(between);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const std::string text = take_text(input, size == 0 || *data >= kPowers);
  const Metadata metadata = Metadata::read(text);
  require(metadata.text() == text, "another text");
  require_limits(metadata);
  check_changes(metadata);
  check_others(metadata);
  if (metadata.is_readable()) check_facts(metadata);
  else require(text_of_facts(metadata.facts()) == "{}", "facts of what cannot be read");
  return 0;
}
