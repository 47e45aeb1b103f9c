#include "octavo/core/json_reader.h"

#include <charconv>
#include <cmath>
#include <cstdlib>

#include "octavo/core/error.h"
#include "octavo/core/utf8.h"

namespace octavo {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The double nearest to a JSON number, whatever language the process speaks.
double parsed(std::string_view number) {
#ifdef __cpp_lib_to_chars
  double value = 0;
  const auto end = number.data() + number.size();
  return std::from_chars(number.data(), end, value).ec == std::errc() ? value : HUGE_VAL;
#else  // in browsers, where there is the C locale only
  return std::strtod(std::string(number).c_str(), nullptr);
#endif
}

}  // namespace

JsonToken JsonReader::next() {
  skip_spaces();
  if (expected_ == Expected::separator && !is_at(is_in_object() ? '}' : ']')) take_separator();
  begin_ = at_;
  token_ = take_token();
  return token_;
}

std::optional<std::int64_t> JsonReader::integer() const {
  if (token_ != JsonToken::integer) return std::nullopt;
  const std::string_view digits = written();
  std::int64_t value = 0;
  const auto end = digits.data() + digits.size();
  if (std::from_chars(digits.data(), end, value).ec != std::errc()) return std::nullopt;
  return value;
}

std::optional<double> JsonReader::number() const {
  if (token_ != JsonToken::integer && token_ != JsonToken::number) return std::nullopt;
  const double value = parsed(written());
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::string_view JsonReader::skip_value() {
  const std::size_t begin = begin_;
  int open = 0;
  for (;;) {
    if (token_ == JsonToken::begin_object || token_ == JsonToken::begin_list) ++open;
    if (token_ == JsonToken::end_object || token_ == JsonToken::end_list) --open;
    if (open == 0) return json_.substr(begin, at_ - begin);
    next();
  }
}

void JsonReader::fail(const std::string& what) const {
  throw Error(ErrorKind::corrupt, what + " at byte " + std::to_string(at_), {}, at_);
}

void JsonReader::skip_spaces() {
  while (is_at(' ') || is_at('\t') || is_at('\n') || is_at('\r')) ++at_;
}

void JsonReader::take_separator() {
  if (!is_at(',')) fail(is_in_object() ? "no ',' or '}'" : "no ',' or ']'");
  ++at_;
  skip_spaces();
  expected_ = is_in_object() ? Expected::name : Expected::value;
}

JsonToken JsonReader::take_token() {
  switch (expected_) {
    case Expected::value: return take_value();
    case Expected::value_or_end: return is_at(']') ? close() : take_value();
    case Expected::separator: return close();
    case Expected::nothing:
      if (at_ < json_.size()) fail("text behind the value");
      return JsonToken::end;
    case Expected::name_or_end:
      if (is_at('}')) return close();
      [[fallthrough]];
    case Expected::name: break;
  }
  if (!is_at('"')) fail("no name of a member");
  take_string();
  skip_spaces();
  if (!is_at(':')) fail("no ':'");
  ++at_;
  expected_ = Expected::value;
  return JsonToken::name;
}

JsonToken JsonReader::take_value() {
  if (at_ == json_.size()) fail("no value");
  if (++values_ > kMaxJsonValues) {
    throw Error(ErrorKind::limit_exceeded,
                "more than " + std::to_string(kMaxJsonValues) + " values", {}, at_);
  }
  switch (json_[at_]) {
    case '{': return open(true);
    case '[': return open(false);
    case '"': take_string(); return ended(JsonToken::string);
    case 't': return take_word("true", JsonToken::boolean);
    case 'f': return take_word("false", JsonToken::boolean);
    case 'n': return take_word("null", JsonToken::null);
    default: return take_number();
  }
}

JsonToken JsonReader::open(bool is_object) {
  if (depth_ == kMaxJsonDepth) {
    throw Error(ErrorKind::limit_exceeded,
                "nested deeper than " + std::to_string(kMaxJsonDepth) + " at byte " +
                    std::to_string(at_),
                {}, at_);
  }
  ++at_;
  ++depth_;
  const std::uint32_t bit = std::uint32_t{1} << depth_;
  objects_ = is_object ? objects_ | bit : objects_ & ~bit;
  expected_ = is_object ? Expected::name_or_end : Expected::value_or_end;
  return is_object ? JsonToken::begin_object : JsonToken::begin_list;
}

JsonToken JsonReader::close() {
  const bool is_object = is_in_object();
  ++at_;
  --depth_;
  return ended(is_object ? JsonToken::end_object : JsonToken::end_list);
}

JsonToken JsonReader::ended(JsonToken value) {
  expected_ = depth_ == 0 ? Expected::nothing : Expected::separator;
  return value;
}

JsonToken JsonReader::take_word(std::string_view word, JsonToken token) {
  if (json_.substr(at_, word.size()) != word) fail("no value");
  at_ += word.size();
  return ended(token);
}

JsonToken JsonReader::take_number() {
  if (is_at('-')) ++at_;
  if (is_at('0')) ++at_;
  else take_digits();
  bool is_integer = true;
  if (is_at('.')) {
    is_integer = false;
    ++at_;
    take_digits();
  }
  if (is_at('e') || is_at('E')) {
    is_integer = false;
    ++at_;
    if (is_at('+') || is_at('-')) ++at_;
    take_digits();
  }
  return ended(is_integer ? JsonToken::integer : JsonToken::number);
}

void JsonReader::take_digits() {
  if (at_ == json_.size() || !is_digit(json_[at_])) fail("no value");
  while (at_ < json_.size() && is_digit(json_[at_])) ++at_;
}

void JsonReader::take_string() {
  ++at_;
  string_.clear();
  while (!is_at('"')) {
    if (at_ == json_.size()) fail("a string without an end");
    if (is_at('\\')) {
      take_escape();
    } else {
      if (static_cast<std::uint8_t>(json_[at_]) < 0x20) fail("a control character");
      const Utf8Piece piece = first_piece(json_.substr(at_));
      if (!piece.is_character) fail("no UTF-8");
      string_ += json_.substr(at_, piece.bytes);
      at_ += piece.bytes;
    }
    if (string_.size() > kMaxJsonStringBytes) {
      throw Error(ErrorKind::limit_exceeded,
                  "a string of more than " + std::to_string(kMaxJsonStringBytes) +
                      " bytes at byte " + std::to_string(begin_),
                  {}, begin_);
    }
  }
  ++at_;
}

void JsonReader::take_escape() {
  constexpr std::string_view kWritten = "\"\\/bfnrt";
  constexpr std::string_view kMeant = "\"\\/\b\f\n\r\t";
  ++at_;
  if (at_ == json_.size()) fail("a string without an end");
  const char escape = json_[at_++];
  if (const std::size_t index = kWritten.find(escape); index != std::string_view::npos) {
    string_ += kMeant[index];
    return;
  }
  if (escape != 'u') fail("an unknown escape");
  std::uint32_t character = take_hex();
  if (character >= 0xd800 && character < 0xdc00) {
    if (json_.substr(at_, 2) != "\\u") fail("half of a surrogate pair");
    at_ += 2;
    const std::uint32_t low = take_hex();
    if (low < 0xdc00 || low > 0xdfff) fail("half of a surrogate pair");
    character = 0x10000 + ((character - 0xd800) << 10) + (low - 0xdc00);
  } else if (character >= 0xdc00 && character <= 0xdfff) {
    fail("half of a surrogate pair");
  }
  append_utf8(string_, character);
}

std::uint32_t JsonReader::take_hex() {
  std::uint32_t value = 0;
  const std::string_view digits = json_.substr(at_, 4);
  const auto end = digits.data() + digits.size();
  const auto [stopped, failure] = std::from_chars(digits.data(), end, value, 16);
  if (digits.size() < 4 || failure != std::errc() || stopped != end) fail("no four hex digits");
  at_ += 4;
  return value;
}

}  // namespace octavo
