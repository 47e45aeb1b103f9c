#include "octavo/io/source/label_table_xml.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/utf8.h"

namespace octavo {

namespace {

constexpr std::string_view kTagBlanks = " \t\r\n";
constexpr std::string_view kOpening = "<Label";
constexpr std::string_view kClosing = "</Label>";

constexpr std::string_view kRaw = "<![CDATA[";
constexpr std::string_view kRawEnd = "]]>";

/// `text` without comments, with their ends of lines.
std::string without_comments(std::string_view text) {
  constexpr std::string_view kComment = "<!--";
  constexpr std::string_view kCommentEnd = "-->";
  std::string rest;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t next = std::min(text.find("<!", at), text.size());
    rest.append(text.substr(at, next - at));
    const bool is_comment = text.substr(next).starts_with(kComment);
    const bool is_raw = text.substr(next).starts_with(kRaw);
    const std::string_view ending = is_comment ? kCommentEnd : is_raw ? kRawEnd : "!";
    const std::size_t last = text.find(ending, next + (is_comment ? kComment.size() : 0));
    at = last >= text.size() ? text.size() : last + ending.size();
    const std::string_view whole = text.substr(next, at - next);
    if (is_comment) {
      rest.append(static_cast<std::size_t>(std::ranges::count(whole, '\n')), '\n');
    } else {
      rest.append(whole);
    }
  }
  return rest;
}

class XmlLabels {
 public:
  explicit XmlLabels(std::string_view text) : made_(without_comments(text)), text_(made_) {}

  std::vector<XmlLabel> read() {
    std::vector<XmlLabel> labels;
    for (std::size_t at = next_label(0); at < text_.size(); at = next_label(at_)) {
      line_ += static_cast<std::size_t>(
          std::count(text_.begin() + static_cast<std::ptrdiff_t>(counted_),
                     text_.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
      counted_ = at;
      at_ = at + kOpening.size();
      labels.push_back(label());
    }
    return labels;
  }

 private:
  using Attributes = std::map<std::string, std::string, std::less<>>;

  [[noreturn]] void reject(const std::string& why) const {
    throw Error(ErrorKind::source_rejected, "line " + std::to_string(line_) + ": " + why);
  }

  /// Where an element begins that is called Label and nothing longer.
  std::size_t next_label(std::size_t at) const {
    for (at = text_.find('<', at); at < text_.size(); at = text_.find('<', at + 1)) {
      const std::string_view rest = text_.substr(at);
      if (rest.starts_with(kRaw)) {
        at = text_.find(kRawEnd, at);
        if (at >= text_.size()) break;
        continue;
      }
      const std::size_t end = kOpening.size();
      const bool is_opening = rest.starts_with(kOpening) && end < rest.size();
      if (is_opening && kTagBlanks.find(rest[end]) != std::string_view::npos) return at;
    }
    return text_.size();
  }

  /// What stands before `end`, behind which reading goes on.
  std::string_view until(std::string_view end) {
    const std::size_t found = text_.find(end, at_);
    if (found == std::string_view::npos) reject("an element is cut off");
    const std::string_view before = text_.substr(at_, found - at_);
    at_ = found + end.size();
    return before;
  }

  void skip_blanks() { at_ = std::min(text_.find_first_not_of(kTagBlanks, at_), text_.size()); }
  bool begins_with(std::string_view word) const { return text_.substr(at_).starts_with(word); }

  Attributes attributes() {
    Attributes found;
    for (skip_blanks(); !begins_with("/>") && !begins_with(">"); skip_blanks()) {
      std::string_view name = until("=");
      name = name.substr(0, name.find_last_not_of(kTagBlanks) + 1);
      skip_blanks();
      const char quote = at_ < text_.size() ? text_[at_] : '\0';
      if (quote != '"' && quote != '\'') reject("an attribute has no quotes");
      ++at_;
      found[std::string(name)] = plain(until(std::string_view(&quote, 1)));
    }
    return found;
  }

  XmlLabel label() {
    const Attributes given = attributes();
    XmlLabel label;
    label.line = line_;
    label.key = value_of(given, given.contains("Index") ? "Index" : "Key");
    label.color = {part_of_color(value_of(given, "Red")), part_of_color(value_of(given, "Green")),
                   part_of_color(value_of(given, "Blue"))};
    if (begins_with("/>")) return label;
    ++at_;
    label.name = name();
    return label;
  }

  std::string name() {
    const std::size_t begin = at_;
    skip_blanks();
    std::string raw;
    if (begins_with(kRaw)) {
      at_ += kRaw.size();
      raw = until(kRawEnd);
      until(kClosing);
    } else {
      at_ = begin;
      raw = plain(until(kClosing));
    }
    const std::size_t first = std::min(raw.find_first_not_of(kTagBlanks), raw.size());
    return raw.substr(first, raw.find_last_not_of(kTagBlanks) + 1 - first);
  }

  std::string value_of(const Attributes& given, std::string_view name) const {
    const auto found = given.find(name);
    if (found == given.end()) reject("a label lacks its " + std::string(name));
    return found->second;
  }

  /// 0 to 1 as 0 to 255.
  std::string part_of_color(const std::string& text) const {
    double part = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, failure] = std::from_chars(text.data(), end, part);
    if (failure != std::errc() || stop != end || !(part >= 0 && part <= 1)) {
      reject("'" + escaped(text) + "' is no part of a color: expected 0 to 1");
    }
    return std::to_string(std::lround(part * 255));
  }

  /// `text` with characters for the references to them.
  std::string plain(std::string_view text) const {
    constexpr std::pair<std::string_view, char> kReferences[] = {
        {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}};
    std::string characters;
    while (!text.empty()) {
      if (text.front() != '&') {
        characters += text.front();
        text.remove_prefix(1);
        continue;
      }
      if (text.starts_with("&#")) {
        append_utf8(characters, numbered(text));
        continue;
      }
      const auto* const found =
          std::find_if(std::begin(kReferences), std::end(kReferences),
                       [&](const auto& reference) { return text.starts_with(reference.first); });
      if (found == std::end(kReferences)) reject("& begins no reference that is known here");
      characters += found->second;
      text.remove_prefix(found->first.size());
    }
    return characters;
  }

  /// The character that a reference like &#233; or &#xe9; gives the number of. Takes it off `text`.
  std::uint32_t numbered(std::string_view& text) const {
    const bool is_hexadecimal = text.starts_with("&#x");
    text.remove_prefix(is_hexadecimal ? 3 : 2);
    std::uint32_t number = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, failure] =
        std::from_chars(text.data(), end, number, is_hexadecimal ? 16 : 10);
    const bool is_character = number > 0 && number <= 0x10ffff && (number & ~0x7ffu) != 0xd800;
    if (failure != std::errc() || stop == end || *stop != ';' || !is_character) {
      reject("&# begins no number of a character");
    }
    text.remove_prefix(static_cast<std::size_t>(stop - text.data()) + 1);
    return number;
  }

  std::string made_;
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  std::size_t counted_ = 0;  // bytes whose lines are counted
};

}  // namespace

std::vector<XmlLabel> labels_in_xml(std::string_view text) { return XmlLabels(text).read(); }

}  // namespace octavo
