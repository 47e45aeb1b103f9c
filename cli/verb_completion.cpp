// octavo completion and manual: made from the option tree, so that they cannot fall behind it.
#include <filesystem>
#include <fstream>
#include <memory>

#include "common/failure.h"
#include "common/option_tree.h"
#include "common/options.h"
#include "text/completion_scripts.h"
#include "text/manual_pages.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kCompletionText = {
    "completion", "Print a completion script for a shell.",
    "Verbs, options and the values of options that have a list of them are completed, and files\n"
    "elsewhere. Installing Octavo puts the scripts where the shells look for them.\n\n"
    "Examples:\n"
    "  eval \"$(octavo completion bash)\"\n"
    "  octavo completion zsh > ~/.zfunc/_octavo\n"
    "  octavo completion fish > ~/.config/fish/completions/octavo.fish"};

constexpr VerbText kManualText = {"manual", "Print a manual page (roff), or write all of them.",
                                  "Without a verb the page of the program.\n\n"
                                  "Examples:\n"
                                  "  octavo manual | man -l -\n"
                                  "  octavo manual build | man -l -\n"
                                  "  octavo manual -o share/man/man1"};

struct ManualArguments {
  std::string verb;
  std::string folder;
};

/// A text about octavo with the name of this program.
std::string of_program(std::string text, const CLI::App& app) {
  constexpr std::string_view kName = "octavo";
  const std::string name = program_name(app);
  for (std::size_t at = 0; (at = text.find(kName, at)) != std::string::npos; at += name.size()) {
    text.replace(at, kName.size(), name);
  }
  return text;
}

std::string script_for(const std::string& shell, const ProgramEntry& program) {
  if (shell == "zsh") return zsh_completion(program);
  if (shell == "fish") return fish_completion(program);
  return bash_completion(program);
}

void write_page(const std::filesystem::path& path, const std::string& text, bool overwrite) {
  if (!overwrite && std::filesystem::exists(path)) {
    throw Error(ErrorKind::io, "exists; use --force to replace it", path.string());
  }
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (!file) throw Error(ErrorKind::io, "the manual page could not be written", path.string());
}

int write_pages(const ProgramEntry& program, const std::string& folder, const Context& context) {
  const std::filesystem::path root(folder);
  std::error_code problem;
  std::filesystem::create_directories(root, problem);
  if (problem) throw Error(ErrorKind::io, problem.message(), folder);
  write_page(root / (program.name + ".1"), program_page(program, OCTAVO_VERSION), context.force);
  for (const VerbEntry& verb : program.verbs) {
    write_page(root / (program.name + "-" + verb.name + ".1"),
               verb_page(program, verb, OCTAVO_VERSION), context.force);
  }
  return kExitDone;
}

int run_manual(const CLI::App& app, const ManualArguments& arguments, const Context& context) {
  const ProgramEntry program = option_tree(app);
  if (!arguments.folder.empty()) return write_pages(program, arguments.folder, context);
  if (arguments.verb.empty()) print(program_page(program, OCTAVO_VERSION));
  for (const VerbEntry& verb : program.verbs) {
    if (verb.name == arguments.verb) print(verb_page(program, verb, OCTAVO_VERSION));
  }
  return kExitDone;
}

}  // namespace

void add_completion(CLI::App& app, Context& context) {
  const auto shell = std::make_shared<std::string>();
  const std::string examples = of_program(kCompletionText.examples, app);
  const VerbText text = {kCompletionText.name, kCompletionText.summary, examples.c_str()};
  Verb verb = add_verb(app, context, text, [&app, shell] {
    print(script_for(*shell, option_tree(app)));
    return kExitDone;
  });
  verb.add_option("shell SHELL", *shell, "The shell")
      .required()
      .check(one_of({"bash", "zsh", "fish"}));
}

void add_manual(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<ManualArguments>();
  const std::string examples = of_program(kManualText.examples, app);
  const VerbText text = {kManualText.name, kManualText.summary, examples.c_str()};
  Verb verb = add_verb(app, context, text, [&app, arguments, &context] {
    return run_manual(app, *arguments, context);
  });
  // This verb is added last, so all verbs are there to be named.
  verb.add_option("verb VERB", arguments->verb, "The verb whose page is printed")
      .check(one_of(verb_names(app)));
  verb.add_option("-o,--output FOLDER", arguments->folder,
                  "Write all pages into this folder instead");
}

}  // namespace octavo::cli
