#include "common/context.h"

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/option_checks.h"
#include "common/quantities.h"
#include "octavo/core/error.h"

namespace octavo::cli {

namespace {

const std::map<std::string, ProgressMode> kProgressModes = {
    {"auto", ProgressMode::automatic}, {"bar", ProgressMode::bar},   {"plain", ProgressMode::plain},
    {"json", ProgressMode::json},      {"none", ProgressMode::none},
};

void say(const std::string& text) {
  const std::string line = "octavo: " + one_line(text) + "\n";
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace

std::string one_line(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    out += byte < 0x20 || byte == 0x7f ? escaped(std::string(1, c)) : std::string(1, c);
  }
  return out;
}

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

void add_global_options(CLI::App& app, Context& context) {
  const std::string group = "Options of every verb";
  app.add_flag("-q,--quiet", context.quiet, "Say nothing but warnings and errors")->group(group);
  app.add_flag("-v,--verbose", context.verbose, "Say what is being done")->group(group);
  app.add_flag("--json", context.json, "Print the result as one JSON object")->group(group);
  app.add_option_function<std::string>(
         "--progress",
         [&context](const std::string& name) { context.progress = kProgressModes.at(name); },
         "auto, bar, plain, json or none, on standard error")
      ->type_name("MODE")
      ->check(CLI::IsMember(kProgressModes))
      ->default_str("auto")
      ->group(group);
  app.add_option("-j,--threads", context.threads, "Worker threads (default: all cores)")
      ->type_name("N")
      ->check(whole_within(1, 1024))
      ->group(group);
  app.add_option_function<std::string>(
         "--max-memory",
         [&context](const std::string& text) { context.max_memory_bytes = parse_bytes(text); },
         "Refuse work that needs more memory than this (500M, 2G)")
      ->type_name("BYTES")
      ->group(group);
  app.add_flag("-f,--force", context.force,
               "Replace output files that exist, or whose build was interrupted or still runs")
      ->group(group);
  app.add_flag("--strict", context.strict, "Treat warnings as errors")->group(group);
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

}  // namespace octavo::cli
