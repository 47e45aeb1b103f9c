// octavo serve and octavo view: files in a browser.
#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/web_browser.h"
#include "octavo/core/url_text.h"
#include "octavo/tasks/files/serve.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kServeText = {
    "serve", "Give out .8vo files over HTTP, with a page that shows them.",
    "The address of the page is printed; it works until the program is stopped. Browsers fetch of\n"
    "a file only what they show. Only the files that are named can be asked for. One that is\n"
    "replaced meanwhile is served as it is then; pages that show the earlier one say so. Links\n"
    "are followed at the start: what a name leads to elsewhere later is not served.\n\n"
    "Others than this machine cannot connect. --bind ADDRESS lets them, and needs --token, which\n"
    "becomes part of every address: who does not know it gets nothing. 0.0.0.0 and :: are all\n"
    "addresses of this machine; those are printed then. What is sent is not encrypted.\n"
    "Pages of other sites may read the files with --allow-origin alone.\n\n"
    "With --as zarr3 each file also stands at its address with .zarr/ behind it, as an OME-Zarr\n"
    "0.5 image whose chunks are decoded when they are asked for: zarr-python and tensorstore take\n"
    "the address. As such a file stays what it was when the program was started.\n\n"
    "Files are given out as they are: of one that was built with --keep-identity a warning says\n"
    "so. As zarr it holds no names.\n\n"
    "Examples:\n"
    "  octavo serve head.8vo\n"
    "  octavo serve head.8vo organs.8vo --port 8080\n"
    "  octavo serve head.8vo --bind 0.0.0.0 --token auto\n"
    "  octavo serve head.8vo --allow-origin https://viewer.example.org\n"
    "  octavo serve head.8vo --as zarr3"};

constexpr VerbText kViewText = {
    "view", "Show an .8vo file in the browser.",
    "Starts 'octavo serve' on a free port and opens the page; it works until the program is\n"
    "stopped. $BROWSER names another browser than that of the desktop. FILE may be a URL: then\n"
    "the browser fetches it itself, which its server must allow for other sites.\n\n"
    "Examples:\n"
    "  octavo view head.8vo\n"
    "  octavo view https://example.org/head.8vo"};

nlohmann::ordered_json site_json(const ServedSite& site) {
  nlohmann::ordered_json said = {
      {"url", site.url}, {"port", site.port}, {"files", site.urls}, {"page", site.has_page}};
  if (!site.other_urls.empty()) said["other_urls"] = site.other_urls;
  if (!site.zarr_urls.empty()) said["zarr3"] = site.zarr_urls;
  return said;
}

void say_where(const ServedSite& site, Context& context) {
  if (context.json) {
    print_json(site_json(site));
    return;
  }
  if (site.has_page) print(site.url + "\n");
  else for (const std::string& url : site.urls) print(url + "\n");
  for (const std::string& url : site.zarr_urls) print("zarr3://" + url + "\n");
  for (const std::string& url : site.other_urls) context.note("also at " + url);
  context.note("serving; Ctrl-C ends it");
}

int run_serve(const ServeOptions& asked, Context& context) {
  ServeOptions options = asked;
  options.on_ready = [&](const ServedSite& site) { say_where(site, context); };
  run_task(serve, options, context);
  return kExitDone;
}

int run_view(const ServeOptions& asked, Context& context) {
  ServeOptions options = asked;
  if (is_url(asked.inputs.front())) {
    options.shown_url = asked.inputs.front();
    options.inputs.clear();
  }
  options.needs_page = true;
  options.on_ready = [&](const ServedSite& site) {
    say_where(site, context);
    if (!open_in_browser(site.url)) context.note("no browser could be started; open the address");
  };
  run_task(serve, options, context);
  return kExitDone;
}

}  // namespace

void add_serve(CLI::App& app, Context& context) {
  auto [verb, options] = add_verb(app, context, kServeText, run_serve);
  options.page_folder = web_page_folder();
  verb.add_option("files FILE", options.inputs, "The .8vo files").required();
  verb.add_option("--port N", options.port, "The port (default: a free one)")
      .check(whole_within(1, 65535));
  verb.add_option("--bind ADDRESS", options.address, "The address to listen at")
      .capture_default_str();
  verb.add_option("--token TOKEN", options.token,
                  "The first part of every address: auto, or 22 letters, digits, - and _ or more");
  verb.add_list("--allow-origin ORIGIN", options.allowed_origins,
                "A site of which pages may read the files, or * for all; can be repeated");
  verb.add_text("--as FORMAT", "Also as another format: zarr3",
                [&made = options](const auto&, const auto&) { made.is_zarr = true; })
      .check(one_of({"zarr3"}));
}

void add_view(CLI::App& app, Context& context) {
  auto [verb, options] = add_verb(app, context, kViewText, run_view);
  options.page_folder = web_page_folder();
  options.inputs.resize(1);
  verb.add_input(options.inputs.front());
}

}  // namespace octavo::cli
