// octavo publish: a folder for any web server.
#include <fmt/format.h>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/web_browser.h"
#include "octavo/core/text.h"
#include "octavo/tasks/files/publish.h"
#include "octavo/tasks/files/web_page.h"
#include "text/fact_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kPublishText = {
    "publish", "Write a folder for any web server: a page that shows .8vo files, and these.",
    "The page needs no program on the server, only files. HOSTING.md in the folder says what to\n"
    "set for nginx, caddy, Apache and S3, which is little. In a folder that is there, other files\n"
    "stay; --force replaces those of the same names. What was published there before stays in the\n"
    "list of the page, behind what is new, as long as it is in the folder.\n\n"
    "Files are published as they are. One that was built with --keep-identity is rejected unless\n"
    "it is given here as well; 'octavo build FILE -o NEW.8vo' makes one without names.\n\n"
    "Examples:\n"
    "  octavo publish head.8vo -o site\n"
    "  octavo publish head.8vo organs.8vo -o site\n"
    "  octavo publish knee.8vo -o site --force     the page lists all three"};

nlohmann::ordered_json published_json(const std::vector<PublishedFile>& files) {
  return json_list(files, [](const PublishedFile& file) -> nlohmann::ordered_json {
    return {{"name", file.name}, {"bytes", file.bytes}};
  });
}

std::string others_text(std::size_t count) {
  return count == 0 ? "" : fmt::format(" and {} more", count);
}

std::string published_text(const PublishOptions& options, const PublishResult& result) {
  std::string text;
  std::uint64_t page_bytes = 0;
  bool is_told_how = false;
  for (const PublishedFile& file : result.page) {
    page_bytes += file.bytes;
    is_told_how = is_told_how || file.name == "HOSTING.md";
  }
  for (const PublishedFile& file : result.volumes) {
    text += fmt::format("{}: {}\n", shown_path(options.output.path + "/" + file.name),
                        bytes_text(file.bytes));
  }
  if (!result.listed.empty()) {
    text += fmt::format("{}/{}: also lists what was published before: {}{}\n",
                        shown_path(options.output.path), kWebListName,
                        one_line(result.listed.front()), others_text(result.listed.size() - 1));
  }
  return text + fmt::format("{}: the page, {} files of {}{}\n", shown_path(options.output.path),
                            result.page.size(), bytes_text(page_bytes),
                            is_told_how ? "; HOSTING.md says how to serve it" : "");
}

int run_publish(const PublishOptions& options, Context& context) {
  const PublishResult result = run_task(publish, options, context);
  print_result(context,
               {{"output", options.output.path},
                {"volumes", published_json(result.volumes)},
                {"page", published_json(result.page)},
                {"listed", result.listed}},
               published_text(options, result));
  return kExitDone;
}

}  // namespace

void add_publish(CLI::App& app, Context& context) {
  auto [verb, options] = add_verb(app, context, kPublishText, run_publish);
  options.page_folder = web_page_folder();
  verb.add_option("files FILE", options.inputs, "The .8vo files or URLs of them").required();
  verb.add_output(options.output, "The folder to write");
  verb.add_flag("--keep-identity", options.keep_identity,
                "Publish files too that keep names, dates and free text of their source");
}

}  // namespace octavo::cli
