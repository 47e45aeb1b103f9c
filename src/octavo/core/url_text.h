// URLs as they may be shown: without user, password, query and fragment, which hold secrets.
#pragma once

#include <string>
#include <string_view>

namespace octavo {

/// True for names that start with http:// or https://, in any case.
bool is_url(std::string_view name);

/// `name` as it may stand in messages, results and logs: "https://host/x.8vo" for
/// "https://user:password@host/x.8vo?token=1"; "https://..." where the host cannot be told from a
/// password. What is no URL stays as it is.
std::string public_name(std::string_view name);

/// `text` with every URL in it as public_name gives it. A URL in a name between single quotes ends
/// with the name, at a quote before a blank, punctuation or the end of the text; any other at a
/// blank, a control character, a double quote, < or >. Punctuation at its end stays.
std::string without_secrets(std::string_view text);

}  // namespace octavo
