#include "octavo/io/images/xml_nesting.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr std::size_t kMostDepth = 1000;
constexpr std::string_view kEndOfName = " \t\r\n/>";

/// What is no element, and ends in a way of its own.
struct Aside {
  std::string_view start;
  std::string_view end;
};

constexpr Aside kAsides[] = {{"<!--", "-->"}, {"<![CDATA[", "]]>"}, {"<?", "?>"}, {"<!", ">"}};

/// The '>' of a tag that starts at the begin of `text`; npos where there is none. One within quotes
/// counts where these hold a '<', which no value may.
std::size_t end_of_tag(std::string_view text) {
  char quote = '\0';
  for (std::size_t at = 1; at < text.size(); ++at) {
    const char next = text[at];
    if (next == '<') break;
    if (quote != '\0') {
      if (next == quote) quote = '\0';
    } else if (next == '"' || next == '\'') {
      quote = next;
    } else if (next == '>') {
      return at;
    }
  }
  const std::size_t plain = text.find('>');
  return plain < text.find('<', 1) ? plain : std::string_view::npos;
}

class Nesting {
 public:
  /// Takes what starts at the '<' that `rest` begins with. Returns how many bytes it has; 0 where
  /// it is damaged.
  std::size_t take(std::string_view rest) {
    for (const Aside& aside : kAsides) {
      if (!rest.starts_with(aside.start)) continue;
      const std::size_t end = rest.find(aside.end, aside.start.size());
      return end == std::string_view::npos ? fail("a part of it is not closed")
                                           : end + aside.end.size();
    }
    const std::size_t end = end_of_tag(rest);
    if (end == std::string_view::npos) return fail("it has a tag without an end");
    const bool is_closing = rest.starts_with("</");
    std::string_view name = rest.substr(is_closing ? 2 : 1);
    name = name.substr(0, name.find_first_of(kEndOfName));
    if (is_closing) {
      if (open_.empty()) return fail("it begins with </" + escaped(name) + ">");
      if (open_.back() != name) {
        return fail("its element " + last_name() + " is closed by </" + escaped(name) + ">");
      }
      open_.pop_back();
    } else if (rest[end - 1] != '/') {
      if (open_.size() == kMostDepth) return fail("its elements are nested too deep");
      open_.push_back(name);
    }
    is_whole_ = open_.empty();
    return end + 1;
  }
  bool is_whole() const { return is_whole_; }
  std::string damage() const {
    if (is_whole_) return {};
    if (!damage_.empty()) return damage_;
    return open_.empty() ? "it has no element" : "its element " + last_name() + " is not closed";
  }

 private:
  std::size_t fail(const std::string& damage) {
    damage_ = damage;
    return 0;
  }
  std::string last_name() const { return escaped(open_.back()); }

  std::vector<std::string_view> open_;
  bool is_whole_ = false;
  std::string damage_;
};

}  // namespace

std::string nesting_damage(std::string_view text) {
  Nesting nesting;
  std::size_t at = text.find('<');
  while (at != std::string_view::npos && !nesting.is_whole()) {
    const std::size_t bytes = nesting.take(text.substr(at));
    if (bytes == 0) break;
    at = text.find('<', at + bytes);
  }
  return nesting.damage();
}

}  // namespace octavo
