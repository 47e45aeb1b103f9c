#include "octavo/io/source/source_identity.h"

#include <utility>

namespace octavo {

namespace {

constexpr std::size_t kMaxValueBytes = std::size_t{1} << 16;

}  // namespace

void SourceIdentity::note(const std::string& name, std::string value) {
  if (value.empty()) return;
  ++counts_[name];
  std::string& text = values_[name];
  if (text.size() + value.size() >= kMaxValueBytes) {
    if (text.empty()) values_.erase(name);
    return;
  }
  if (!noted_[name].insert(value).second) return;
  if (text.empty()) {
    text = std::move(value);
  } else if (("\n" + text + "\n").find("\n" + value + "\n") == std::string::npos) {
    text += "\n" + value;
  }
}

void SourceIdentity::note_lost(const std::string& name, std::int64_t count) {
  if (count > 0) counts_[name] += count;
}

IdentityNote SourceIdentity::note_for_file(bool keep) const {
  IdentityNote identity;
  identity.kept = keep;
  if (keep) identity.attributes = values_;
  for (const auto& [name, count] : counts_) {
    if (!keep || !values_.contains(name)) identity.dropped[name] = count;
  }
  return identity;
}

}  // namespace octavo
