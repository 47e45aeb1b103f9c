#include "parts/planned_work.h"

#include <algorithm>
#include <any>
#include <array>
#include <optional>

#include "common/options.h"
#include "common/task_run.h"
#include "octavo/core/error.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr std::array kComputing = {"threshold", "condense", "transform", "combine", "components"};

template <class Options>
std::optional<ComputedWork> work_of(const std::any& taken) {
  const auto* const options = std::any_cast<Options>(&taken);
  return options == nullptr ? std::nullopt : std::optional<ComputedWork>(*options);
}

void require_own_words(const std::vector<std::string>& words) {
  if (words.empty() || std::ranges::find(kComputing, words.front()) == kComputing.end()) {
    throw Error(ErrorKind::invalid_argument,
                "plan -- is followed by threshold, condense, transform, combine or components");
  }
  for (const std::string& word : words) {
    if (word != "-o" && !word.starts_with("--output")) continue;
    throw Error(ErrorKind::invalid_argument,
                "the file that " + words.front() + " makes is named by octavo join");
  }
}

void require_no_globals(const Context& context) {
  const Context none;
  if (context.quiet == none.quiet && context.verbose == none.verbose &&
      context.json == none.json && context.force == none.force && context.strict == none.strict &&
      context.progress == none.progress && context.threads == none.threads &&
      context.max_memory_bytes == none.max_memory_bytes && context.timeout_s == none.timeout_s &&
      context.max_voxels == none.max_voxels) {
    return;
  }
  throw Error(ErrorKind::invalid_argument, "options of every verb stand before --");
}

}  // namespace

std::vector<std::string> without_planned_words(std::vector<std::string> words,
                                               const std::string& verb, Context& context) {
  const auto dashes = std::ranges::find(words, "--");
  const bool is_plan = verb == "plan" && std::find(words.begin(), dashes, verb) != dashes;
  if (!is_plan || dashes == words.end()) return words;
  context.planned.assign(dashes, words.end());
  words.erase(dashes, words.end());
  return words;
}

ComputedWork parse_work(const std::vector<std::string>& words) {
  require_own_words(words);
  Context context;
  std::any taken;
  context.taken = &taken;
  std::vector<std::string> all = words;
  all.insert(all.end(), {"--output", "work.8vo"});
  parse_words(all, [&](CLI::App& app) {
    add_threshold(app, context);
    add_condense(app, context);
    add_transform(app, context);
    add_combine(app, context);
    add_components(app, context);
  });
  require_no_globals(context);
  try {
    context.run();
  } catch (const OptionsTaken&) {
    // What was understood is in `taken`.
  }
  for (const auto& work :
       {work_of<ThresholdOptions>(taken), work_of<CondenseVolumeOptions>(taken),
        work_of<TransformOptions>(taken), work_of<CombineOptions>(taken),
        work_of<LabelComponentsOptions>(taken)}) {
    if (work) return *work;
  }
  if (words.front() == "components") {
    throw Error(ErrorKind::invalid_argument,
                "plan -- components needs --numbers FILE, which components --join writes");
  }
  throw Error(ErrorKind::internal, "the options of " + words.front() + " were not understood");
}

}  // namespace octavo::cli
