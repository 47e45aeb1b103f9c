#include "common/context.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>
#include <thread>
#include <utility>

#include "common/options.h"
#include "octavo/core/error.h"
#include "octavo/core/url_text.h"
#include "octavo/core/utf8.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

/// kept  control characters that stay
std::string without_controls(std::string_view text, std::string_view kept) {
  std::string out;
  while (!text.empty()) {
    const std::string_view piece = text.substr(0, first_piece(text).bytes);
    out += has_control(piece, kept) ? escaped(piece) : std::string(piece);
    text.remove_prefix(piece.size());
  }
  return out;
}

void say(const std::string& text) {
  const std::string line = "octavo: " + one_line(text) + "\n";
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace

std::string one_line(const std::string& text) { return without_controls(text, ""); }

std::string shown_path(const std::string& path) { return one_line(public_name(path)); }

void Context::note(const std::string& text) const {
  if (!quiet) say(text);
}

void Context::detail(const std::string& text) const {
  if (verbose) say(text);
}

void Context::warn(const std::string& text) {
  if (strict) {
    throw Error(ErrorKind::source_rejected, text + "; --strict makes this warning an error");
  }
  warnings.push_back(text);
  say("warning: " + text);
}

int Context::thread_count() const {
  if (threads > 0) return threads;
  return static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

void print(const std::string& text) {
  const bool ok = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() &&
                  std::fflush(stdout) == 0;
  if (!ok) {
    throw Error(ErrorKind::io, std::string("cannot write: ") + std::strerror(errno),
                "standard output");
  }
}

void print_json(const nlohmann::ordered_json& object) {
  print(object.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

void print_result(const Context& context, nlohmann::ordered_json object, const std::string& text) {
  print_finding(context, true, std::move(object), text);
}

void print_finding(const Context& context, bool is_success, nlohmann::ordered_json object,
                   const std::string& text) {
  if (context.json) {
    object["warnings"] = context.warnings;
    print_json(object);
  } else if (!context.quiet || !is_success) {
    print(without_controls(text, "\n\t"));
  }
}

}  // namespace octavo::cli
