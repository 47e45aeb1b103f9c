// Which answer a request gets. No sockets here: a head in, a head and a range of bytes out.
//
//     request                                      answer
//     a Host that is not this machine's            403
//     an Origin that is not allowed                403
//     an address that is not in the table          404; nor behind a folder that is in it
//     what stands there but cannot be read         500
//     anything but GET and HEAD                    405; OPTIONS for allowed origins 204
//     If-Match of other bytes                      412
//     If-None-Match of these bytes                 304
//     a range without a byte of the file           416
//     a range, and no If-Range or that of now      206
//     all else                                     200, all of it
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/io/serve/request_head.h"
#include "octavo/io/serve/served_content.h"

namespace octavo {

/// The addresses of a site: nothing else can be asked for, whatever stands in a path.
using SiteTable = std::map<std::string, std::unique_ptr<ServedContent>, std::less<>>;

struct SiteRules {
  /// "127.0.0.1:8080" and its other names; any Host is taken where it is empty.
  std::vector<std::string> hosts;
  /// Origins that may read: "https://example.org", or "*" for all.
  std::vector<std::string> allowed_origins;
};

struct SiteAnswer {
  int status = 200;
  std::string head;  ///< status line and fields, with the empty line
  std::string text;  ///< a short body; or
  std::shared_ptr<const ServedBytes> bytes;  ///< these bytes
  std::uint64_t first = 0;
  std::uint64_t length = 0;
  bool keeps_alive = true;
};

/// Bytes [first, first + length) of `size`.
struct ServedRange {
  std::uint64_t first = 0;
  std::uint64_t length = 0;
  bool operator==(const ServedRange&) const = default;
};

enum class RangeState { none, some, wrong };

/// What a Range field asks for. Units other than bytes, several ranges and what is no range count
/// as none, which RFC 9110 lets servers ignore; a range that has no byte of the file as wrong.
RangeState parse_asked_range(std::string_view field, std::uint64_t size, ServedRange& range);

/// Whether a request is for what stands behind a folder of the table: the answer may take time to
/// make. Any thread may make it, and several at once.
bool is_behind_folder(const RequestHead& head, const SiteTable& table);

/// The answer to a request. Never throws for anything that a request can hold.
SiteAnswer site_answer(const RequestHead& head, const SiteRules& rules, SiteTable& table);

/// The answer to a head that was not understood; the connection ends with it.
SiteAnswer error_answer(int status);

}  // namespace octavo
