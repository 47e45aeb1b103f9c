// Declares a verb: its name, its help, the global options, and what runs when it is chosen.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "common/context.h"

namespace octavo::cli {

struct VerbText {
  const char* name;
  const char* summary;   ///< one sentence
  const char* examples;  ///< shown below the options
};

/// Adds a verb whose work is `run`; the caller adds its options. `run` returns the exit code.
inline CLI::App& add_verb(CLI::App& app, Context& context, const VerbText& text,
                          std::function<int()> run) {
  CLI::App& verb = *app.add_subcommand(text.name, text.summary);
  verb.footer(text.examples);
  verb.callback([&context, name = std::string(text.name), work = std::move(run)] {
    context.verb = name;
    context.run = work;
  });
  add_global_options(verb, context);
  return verb;
}

}  // namespace octavo::cli
