#include <bit>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <utility>

#include "octavo/io/dicom/dicom_file.h"

namespace octavo {

namespace {

std::string without_padding(const std::string& raw) {
  constexpr const char* kBlanks = " \t\r\n";
  const std::string text = raw.substr(0, raw.find('\0'));
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::optional<double> parse_decimal(const std::string& text) {
  const std::string word = without_padding(text);
  const char* start = word.data() + (word.starts_with('+') ? 1 : 0);
  double value = 0;
  const auto [end, failure] = std::from_chars(start, word.data() + word.size(), value);
  if (failure != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

}  // namespace

std::string dicom_tag_text(DicomTag tag) {
  char text[16];
  std::snprintf(text, sizeof text, "(%04x,%04x)", tag >> 16, tag & 0xffffU);
  return text;
}

bool DicomSet::has(DicomTag tag) const { return values_.contains(tag) || sequences_.contains(tag); }

std::string DicomSet::text(DicomTag tag) const {
  const auto found = values_.find(tag);
  return found == values_.end() ? std::string{} : without_padding(found->second);
}

std::vector<double> DicomSet::decimals(DicomTag tag) const {
  std::vector<double> result;
  const std::string all = text(tag);
  for (std::size_t at = 0; !all.empty() && at <= all.size();) {
    const std::size_t end = std::min(all.find('\\', at), all.size());
    const std::optional<double> value = parse_decimal(all.substr(at, end - at));
    if (!value) return {};
    result.push_back(*value);
    at = end + 1;
  }
  return result;
}

std::optional<double> DicomSet::decimal(DicomTag tag) const {
  const std::vector<double> all = decimals(tag);
  return all.empty() ? std::nullopt : std::optional(all.front());
}

std::optional<std::int64_t> DicomSet::unsigned_value(DicomTag tag) const {
  const auto found = values_.find(tag);
  if (found == values_.end() || (found->second.size() != 2 && found->second.size() != 4)) {
    return std::nullopt;
  }
  const std::string& bytes = found->second;
  std::int64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const std::size_t from = big_endian_ ? i : bytes.size() - 1 - i;
    value = value << 8 | static_cast<unsigned char>(bytes[from]);
  }
  return value;
}

std::vector<std::uint16_t> DicomSet::words(DicomTag tag) const {
  const auto found = values_.find(tag);
  if (found == values_.end() || found->second.size() % 2 != 0) return {};
  const std::string& bytes = found->second;
  std::vector<std::uint16_t> result;
  for (std::size_t i = 0; i < bytes.size(); i += 2) {
    const auto low = static_cast<unsigned char>(bytes[big_endian_ ? i + 1 : i]);
    const auto high = static_cast<unsigned char>(bytes[big_endian_ ? i : i + 1]);
    result.push_back(static_cast<std::uint16_t>(high << 8 | low));
  }
  return result;
}

std::optional<double> DicomSet::float64(DicomTag tag) const {
  const auto found = values_.find(tag);
  if (found == values_.end() || found->second.size() != sizeof(double)) return std::nullopt;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < sizeof(double); ++i) {
    const std::size_t from = big_endian_ ? i : sizeof(double) - 1 - i;
    bits = bits << 8 | static_cast<unsigned char>(found->second[from]);
  }
  const auto value = std::bit_cast<double>(bits);
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

const std::vector<DicomSet>& DicomSet::items(DicomTag tag) const {
  static const std::vector<DicomSet> kNone;
  const auto found = sequences_.find(tag);
  return found == sequences_.end() ? kNone : found->second;
}

void DicomSet::add_value(DicomTag tag, std::string bytes) { values_[tag] = std::move(bytes); }

void DicomSet::add_item(DicomTag tag, DicomSet item) { sequences_[tag].push_back(std::move(item)); }

}  // namespace octavo
