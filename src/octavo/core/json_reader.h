// JSON from strangers, token by token: no tree, no recursion, and limits that end every text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace octavo {

constexpr int kMaxJsonDepth = 16;                        // of objects and lists in one another
constexpr std::size_t kMaxJsonValues = 65536;            // objects and lists count as well
constexpr std::size_t kMaxJsonStringBytes = std::size_t{1} << 16;  // of a string or name, decoded

enum class JsonToken {
  begin_object,
  end_object,
  begin_list,
  end_list,
  name,  ///< of a member; its value follows
  string,
  integer,  ///< a number without a point and an exponent
  number,   ///< any other number
  boolean,
  null,
  end,  ///< behind the one value that a text is
};

/// Reads one JSON value (RFC 8259) in UTF-8. What it hands out is valid whatever the text is.
/// Memory  the text is not copied and must outlive the reader; one string at a time is decoded
class JsonReader {
 public:
  explicit JsonReader(std::string_view text) : json_(text) {}

  /// Moves to the next token and returns it.
  /// Throws  Error{corrupt} at the offset of what is no JSON, no UTF-8 or breaks off;
  ///         Error{limit_exceeded} beyond the limits above. Nothing may be read after that
  JsonToken next();
  /// The token it stands at. Requires a call of next().
  JsonToken token() const { return token_; }

  /// The name or the string it stands at, decoded.
  const std::string& string() const { return string_; }
  /// The integer it stands at; nothing where it is none of 64 bits.
  std::optional<std::int64_t> integer() const;
  /// The integer or number it stands at; nothing where no double is as large.
  std::optional<double> number() const;
  bool boolean() const { return json_[begin_] == 't'; }
  /// The token as it is written.
  std::string_view written() const { return json_.substr(begin_, at_ - begin_); }

  /// Moves from the first token of a value to its last one, and returns it as it is written.
  std::string_view skip_value();

 private:
  enum class Expected { value, value_or_end, name, name_or_end, separator, nothing };

  [[noreturn]] void fail(const std::string& what) const;
  bool is_at(char character) const { return at_ < json_.size() && json_[at_] == character; }
  bool is_in_object() const { return (objects_ >> depth_ & 1) != 0; }
  void skip_spaces();
  void take_separator();
  JsonToken take_token();
  JsonToken take_value();
  JsonToken open(bool is_object);
  JsonToken close();
  JsonToken ended(JsonToken value);
  JsonToken take_word(std::string_view word, JsonToken token);
  JsonToken take_number();
  void take_digits();
  void take_string();
  void take_escape();
  std::uint32_t take_hex();

  std::string_view json_;
  std::size_t at_ = 0;
  std::size_t begin_ = 0;  // of the token
  JsonToken token_ = JsonToken::end;
  Expected expected_ = Expected::value;
  int depth_ = 0;
  std::uint32_t objects_ = 0;  // bit d: what is open at depth d is an object
  std::size_t values_ = 0;
  std::string string_;
};

}  // namespace octavo
