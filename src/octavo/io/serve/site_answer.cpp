#include "octavo/io/serve/site_answer.h"

#include <algorithm>
#include <limits>

namespace octavo {

namespace {

struct StatusText {
  int status;
  const char* text;
};

constexpr StatusText kStatusTexts[] = {
    {200, "OK"},
    {204, "No Content"},
    {206, "Partial Content"},
    {302, "Found"},
    {304, "Not Modified"},
    {400, "Bad Request"},
    {403, "Forbidden"},
    {404, "Not Found"},
    {405, "Method Not Allowed"},
    {408, "Request Timeout"},
    {412, "Precondition Failed"},
    {416, "Range Not Satisfiable"},
    {431, "Request Header Fields Too Large"},
    {500, "Internal Server Error"},
    {503, "Service Unavailable"},
    {505, "HTTP Version Not Supported"},
};

constexpr std::string_view kPagePolicy =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; "
    "style-src 'self'; img-src 'self' blob: data:; connect-src 'self' http: https: blob:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

std::string status_line(int status) {
  for (const StatusText& row : kStatusTexts) {
    if (row.status == status) return "HTTP/1.1 " + std::to_string(status) + " " + row.text + "\r\n";
  }
  return "HTTP/1.1 " + std::to_string(status) + " Error\r\n";
}

bool is_listed(const std::vector<std::string>& list, std::string_view text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

/// "a", "b" or *: whether a tag stands in the list of an If-Match or If-None-Match.
bool is_tag_in(std::string_view list, const std::string& tag, bool takes_weak) {
  if (list == "*") return true;
  while (!list.empty()) {
    const std::size_t comma = list.find(',');
    std::string_view one = list.substr(0, comma);
    while (one.starts_with(' ') || one.starts_with('\t')) one.remove_prefix(1);
    while (one.ends_with(' ') || one.ends_with('\t')) one.remove_suffix(1);
    if (takes_weak && one.starts_with("W/")) one.remove_prefix(2);
    if (one == tag) return true;
    if (comma == std::string_view::npos) break;
    list.remove_prefix(comma + 1);
  }
  return false;
}

/// Whether a text begins with another one, which is in lower case, in letters of either case.
bool starts_with_word(std::string_view text, std::string_view word) {
  if (text.size() < word.size()) return false;
  return std::equal(word.begin(), word.end(), text.begin(), [](char of_word, char c) {
    return of_word == (c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c);
  });
}

std::optional<std::uint64_t> number_of(std::string_view digits) {
  if (digits.empty()) return std::nullopt;
  std::uint64_t value = 0;
  for (const char c : digits) {
    if (c < '0' || c > '9') return std::nullopt;
    const auto digit = static_cast<std::uint64_t>(c - '0');
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
    value = value > (kMost - digit) / 10 ? kMost : value * 10 + digit;
  }
  return value;
}

/// Where a path is looked up.
std::string_view table_path(const RequestHead& head) {
  return head.path == "/" ? std::string_view("/index.html") : std::string_view(head.path);
}

/// The entry of the table with the longest name that the path goes on behind.
SiteTable::const_iterator entry_above(std::string_view path, const SiteTable& table) {
  for (std::size_t end = path.rfind('/'); end != path.npos && end > 0;
       end = path.rfind('/', end - 1)) {
    const auto folder = table.find(path.substr(0, end + 1));
    if (folder != table.end()) return folder;
  }
  return table.end();
}

/// One request on its way to an answer.
class Answering {
 public:
  Answering(const RequestHead& head, const SiteRules& rules, SiteTable& table)
      : head_(head), rules_(rules), table_(table) {}

  SiteAnswer answer() {
    if (!rules_.hosts.empty() && !is_listed(rules_.hosts, head_.host)) return plain(403);
    if (head_.origin && !is_own_origin() && !is_allowed_origin()) return plain(403);
    if (head_.method == "OPTIONS" && is_allowed_origin()) return preflight();
    if (head_.method != "GET" && head_.method != "HEAD") {
      fields_ += "Allow: GET, HEAD\r\n";
      return plain(405);
    }
    const auto found = table_.find(table_path(head_));
    if (found == table_.end()) return of_folder();
    const auto bytes = found->second->now();
    if (!bytes) return plain(404);
    return of_content(found->second->media_type(), bytes);
  }

 private:
  bool is_own_origin() const { return *head_.origin == "http://" + head_.host; }

  bool is_allowed_origin() const {
    return head_.origin && (is_listed(rules_.allowed_origins, *head_.origin) ||
                            is_listed(rules_.allowed_origins, "*"));
  }

  /// Fields of every answer.
  std::string common_fields() const {
    std::string fields = "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n";
    const bool is_shared = !rules_.allowed_origins.empty();
    fields += std::string("Cross-Origin-Resource-Policy: ") +
              (is_shared ? "cross-origin" : "same-origin") + "\r\n";
    if (is_shared) fields += "Vary: Origin\r\n";
    if (is_allowed_origin()) {
      fields += "Access-Control-Allow-Origin: " + *head_.origin + "\r\n" +
                "Access-Control-Expose-Headers: Accept-Ranges, Content-Length, Content-Range, "
                "ETag\r\n";
    }
    if (!head_.keeps_alive) fields += "Connection: close\r\n";
    return fields;
  }

  SiteAnswer finished(int status, std::uint64_t length) const {
    SiteAnswer answer;
    answer.status = status;
    answer.head = status_line(status) + common_fields() + fields_;
    if (status != 204 && status != 304) {
      answer.head += "Content-Length: " + std::to_string(length) + "\r\n";
    }
    answer.head += "\r\n";
    answer.keeps_alive = head_.keeps_alive;
    return answer;
  }

  SiteAnswer plain(int status) {
    const std::string text = std::to_string(status) + "\n";
    fields_ += "Content-Type: text/plain; charset=utf-8\r\nCache-Control: no-store\r\n";
    SiteAnswer answer = finished(status, text.size());
    if (head_.method != "HEAD") answer.text = text;
    return answer;
  }

  SiteAnswer preflight() {
    fields_ += "Access-Control-Allow-Methods: GET, HEAD\r\n"
               "Access-Control-Allow-Headers: Range, If-Range, If-Match, If-None-Match\r\n"
               "Access-Control-Max-Age: 600\r\n";
    if (head_.asks_private_network) fields_ += "Access-Control-Allow-Private-Network: true\r\n";
    return finished(204, 0);
  }

  SiteAnswer of_folder() {
    const auto folder = entry_above(head_.path, table_);
    if (folder == table_.end()) return plain(404);
    const std::string_view key = std::string_view(head_.path).substr(folder->first.size());
    const std::optional<ServedPart> part = folder->second->beneath(key);
    if (!part) return plain(404);
    return part->bytes ? of_content(part->media_type, part->bytes) : plain(500);
  }

  SiteAnswer of_content(const std::string& type, std::shared_ptr<const ServedBytes> bytes) {
    const std::string& tag = bytes->entity_tag();
    const std::uint64_t size = bytes->size();
    const std::string kept = "Cache-Control: no-cache\r\n";
    fields_ += "ETag: " + tag + "\r\nAccept-Ranges: bytes\r\n";
    if (head_.if_match && !is_tag_in(*head_.if_match, tag, false)) return plain(412);
    if (head_.if_none_match && is_tag_in(*head_.if_none_match, tag, true)) {
      fields_ += kept;
      return finished(304, 0);
    }
    ServedRange range{0, size};
    RangeState state = RangeState::none;
    const bool is_of_now = !head_.if_range || *head_.if_range == tag;
    if (head_.range && is_of_now) state = parse_asked_range(*head_.range, size, range);
    if (state == RangeState::wrong) {
      fields_ += "Content-Range: bytes */" + std::to_string(size) + "\r\n";
      return plain(416);
    }
    fields_ += kept + "Content-Type: " + type + "\r\n";
    if (type.starts_with("text/html")) {
      fields_ += "Content-Security-Policy: " + std::string(kPagePolicy) + "\r\n";
    }
    if (state == RangeState::some) {
      fields_ += "Content-Range: bytes " + std::to_string(range.first) + "-" +
                 std::to_string(range.first + range.length - 1) + "/" + std::to_string(size) +
                 "\r\n";
    }
    SiteAnswer answer = finished(state == RangeState::some ? 206 : 200, range.length);
    if (head_.method != "HEAD") {
      answer.bytes = std::move(bytes);
      answer.first = range.first;
      answer.length = range.length;
    }
    return answer;
  }

  const RequestHead& head_;
  const SiteRules& rules_;
  SiteTable& table_;
  std::string fields_;
};

}  // namespace

RangeState parse_asked_range(std::string_view field, std::uint64_t size, ServedRange& range) {
  constexpr std::string_view kUnit = "bytes=";
  if (!starts_with_word(field, kUnit)) return RangeState::none;
  field.remove_prefix(kUnit.size());
  const std::size_t dash = field.find('-');
  if (dash == std::string_view::npos) return RangeState::none;
  const std::string_view low = field.substr(0, dash);
  const std::string_view high = field.substr(dash + 1);
  const auto last = number_of(high);
  if (!high.empty() && !last) return RangeState::none;
  if (low.empty()) {
    // The last bytes.
    if (!last) return RangeState::none;
    if (*last == 0 || size == 0) return RangeState::wrong;
    const std::uint64_t length = std::min(*last, size);
    range = {size - length, length};
    return RangeState::some;
  }
  const auto first = number_of(low);
  if (!first || (last && *last < *first)) return RangeState::none;
  if (*first >= size) return RangeState::wrong;
  const std::uint64_t end = last ? std::min(*last, size - 1) : size - 1;
  range = {*first, end - *first + 1};
  return RangeState::some;
}

bool is_behind_folder(const RequestHead& head, const SiteTable& table) {
  return table.find(table_path(head)) == table.end() &&
         entry_above(head.path, table) != table.end();
}

SiteAnswer site_answer(const RequestHead& head, const SiteRules& rules, SiteTable& table) {
  return Answering(head, rules, table).answer();
}

SiteAnswer error_answer(int status) {
  SiteAnswer answer;
  answer.status = status;
  answer.text = std::to_string(status) + "\n";
  answer.head = status_line(status) +
                "X-Content-Type-Options: nosniff\r\nContent-Type: text/plain; charset=utf-8\r\n"
                "Cache-Control: no-store\r\nConnection: close\r\nContent-Length: " +
                std::to_string(answer.text.size()) + "\r\n\r\n";
  answer.keeps_alive = false;
  return answer;
}

}  // namespace octavo
