// octavo publish: a folder for any web server.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/web_browser.h"
#include "octavo/core/text.h"
#include "octavo/tasks/files/publish.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kPublishText = {
    "publish", "Write a folder for any web server: a page that shows .8vo files, and these.",
    "The page needs no program on the server, only files. HOSTING.md in the folder says what to\n"
    "set for nginx, caddy, Apache and S3, which is little. In a folder that is there, other files\n"
    "stay; --force replaces those of the same names.\n\n"
    "Examples:\n"
    "  octavo publish head.8vo -o site\n"
    "  octavo publish head.8vo organs.8vo -o site --force"};

struct PublishArguments {
  std::vector<std::string> inputs;
  std::string output;
};

nlohmann::ordered_json published_json(const std::vector<PublishedFile>& files) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const PublishedFile& file : files) {
    list.push_back({{"name", file.name}, {"bytes", file.bytes}});
  }
  return list;
}

std::string published_text(const PublishArguments& arguments, const PublishResult& result) {
  std::string text;
  std::uint64_t page_bytes = 0;
  bool is_told_how = false;
  for (const PublishedFile& file : result.page) {
    page_bytes += file.bytes;
    is_told_how = is_told_how || file.name == "HOSTING.md";
  }
  for (const PublishedFile& file : result.volumes) {
    text += fmt::format("{}/{}: {}\n", arguments.output, file.name, bytes_text(file.bytes));
  }
  return text + fmt::format("{}: the page, {} files of {}{}\n", arguments.output,
                            result.page.size(), bytes_text(page_bytes),
                            is_told_how ? "; HOSTING.md says how to serve it" : "");
}

int run_publish(const PublishArguments& arguments, Context& context) {
  PublishOptions options;
  options.inputs = arguments.inputs;
  options.page_folder = web_page_folder();
  options.output = {arguments.output, context.force};
  const PublishResult result = run_task(publish, options, context);
  print_result(context,
               {{"output", arguments.output},
                {"volumes", published_json(result.volumes)},
                {"page", published_json(result.page)}},
               published_text(arguments, result));
  return kExitDone;
}

}  // namespace

void add_publish(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<PublishArguments>();
  Verb verb = add_verb(app, context, kPublishText,
                       [arguments, &context] { return run_publish(*arguments, context); });
  verb.add_option("files", arguments->inputs, "The .8vo files or URLs of them")
      ->type_name("FILE")
      ->required();
  verb.add_output(arguments->output, "The folder to write");
}

}  // namespace octavo::cli
