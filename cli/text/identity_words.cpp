#include "text/identity_words.h"

#include <fmt/format.h>

#include <map>

#include "common/context.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

std::map<std::string, std::string> kept_in(const Metadata& metadata) {
  const auto& identity = metadata.facts().identity;
  return identity && identity->attributes ? *identity->attributes
                                          : std::map<std::string, std::string>();
}

std::map<std::string, std::int64_t> dropped_in(const Metadata& metadata) {
  const auto& identity = metadata.facts().identity;
  return identity ? identity->dropped : std::map<std::string, std::int64_t>();
}

std::string counted(std::size_t count) {
  return counted_text(static_cast<std::int64_t>(count), "attribute");
}

}  // namespace

const char* identity_state(const Metadata& metadata) {
  if (metadata.keeps_identity()) return "kept";
  return dropped_in(metadata).empty() ? "none" : "dropped";
}

std::string identity_words(const Metadata& metadata) {
  const std::size_t kept = kept_in(metadata).size();
  const std::size_t dropped = dropped_in(metadata).size();
  if (kept > 0) {
    return fmt::format("kept: {} that may tell who or where {} in this file (--metadata)",
                       counted(kept), kept == 1 ? "is" : "are");
  }
  if (dropped == 0) return "";
  return fmt::format("dropped: {} of the source left out (--metadata)", counted(dropped));
}

std::string identity_lines(const Metadata& metadata) {
  std::string text;
  const auto kept = kept_in(metadata);
  if (!kept.empty()) text += "\n  kept of what may tell who or where:\n";
  for (const auto& [name, value] : kept) {
    text += fmt::format("    {:<36} {}\n", one_line(name), one_line(value));
  }
  const auto dropped = dropped_in(metadata);
  if (!dropped.empty()) text += "\n  dropped, and how often it was there:\n";
  for (const auto& [name, count] : dropped) {
    text += fmt::format("    {:<36} {}\n", one_line(name), count > 0 ? count_text(count) : "");
  }
  return text;
}

}  // namespace octavo::cli
