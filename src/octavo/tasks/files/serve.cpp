#include "octavo/tasks/files/serve.h"

#include <algorithm>
#include <random>
#include <string_view>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/url_text.h"
#include "octavo/io/serve/own_addresses.h"
#include "octavo/io/serve/site_server.h"
#include "octavo/io/zarr/served_zarr.h"
#include "octavo/tasks/files/web_page.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

namespace {

constexpr const char* kZarrEnding = ".zarr/";
constexpr std::size_t kMinTokenLength = 22;  // 128 bits, of 64 signs
constexpr std::string_view kTokenSigns =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";

bool is_loopback(const std::string& address) {
  return address == "::1" || address.starts_with("127.");
}

std::string new_token() {
  std::random_device device;
  std::string token;
  while (token.size() < kMinTokenLength) {
    token.push_back(kTokenSigns[device() % kTokenSigns.size()]);
  }
  return token;
}

std::string token_of(const ServeOptions& options) {
  if (options.token == kNewToken) return new_token();
  if (options.token.empty()) {
    if (is_loopback(options.address)) return "";
    throw Error(ErrorKind::invalid_argument,
                "others than this machine can read at " + escaped(options.address) +
                    "; that needs a token")
        .with_field("serve.token");
  }
  const bool is_right =
      options.token.size() >= kMinTokenLength &&
      options.token.find_first_not_of(kTokenSigns) == std::string::npos;
  if (is_right) return options.token;
  throw Error(ErrorKind::invalid_argument,
              "a token has at least 22 letters, digits, - and _")
      .with_field("serve.token");
}

void check_origins(const std::vector<std::string>& origins) {
  for (const std::string& origin : origins) {
    const std::size_t scheme = origin.find("://");
    const bool is_right =
        origin == "*" ||
        (is_url(origin) && scheme != std::string::npos &&
         origin.find_first_of("/?#@ \r\n", scheme + 3) == std::string::npos);
    if (is_right) continue;
    throw Error(ErrorKind::invalid_argument,
                "'" + escaped(origin) + "' is no origin; https://example.org is one, and * is all")
        .with_field("serve.allowed_origins");
  }
}

std::vector<std::uint8_t> bytes_of(std::string_view text) {
  return {text.begin(), text.end()};
}

/// What stands at which address.
class Site {
 public:
  /// volumes  open, where files also stand as zarr
  Site(const ServeOptions& options, std::string token,
       const std::vector<std::shared_ptr<FileReader>>& volumes)
      : root_(token.empty() ? "/" : "/" + token + "/") {
    const std::vector<std::string> page = page_files(options);
    for (const std::string& name : page) {
      put(name, file_content(options.page_folder + "/" + name, media_type_of(name)));
    }
    names_ = web_names(options.inputs, page);
    for (std::size_t i = 0; i < names_.size(); ++i) {
      put(names_[i], file_content(options.inputs[i], media_type_of(".8vo")));
      if (!options.is_zarr) continue;
      const std::string stem = names_[i].substr(0, names_[i].rfind('.'));
      put(names_[i] + kZarrEnding, zarr_content(volumes[i], stem));
    }
    is_zarr_ = options.is_zarr;
    const std::string list = web_list(web_rows(names_));
    put(kWebListName, memory_content(bytes_of(list), media_type_of(kWebListName)));
    has_page_ = !page.empty();
    if (has_page_) {
      table_[root_] = file_content(options.page_folder + "/index.html", media_type_of(".html"));
    }
  }

  bool has_page() const { return has_page_; }
  SiteTable& table() { return table_; }

  /// hosts  with ports; the first one stands in most addresses
  ServedSite at(const std::vector<std::string>& hosts, int port,
                const std::string& shown_url) const {
    ServedSite site;
    site.port = port;
    site.has_page = has_page_;
    const std::string base = "http://" + hosts.front() + root_;
    for (const std::string& name : names_) site.urls.push_back(base + percent_encoded(name));
    for (const std::string& url : site.urls) {
      if (is_zarr_) site.zarr_urls.push_back(url + kZarrEnding);
    }
    std::string shown = shown_url.empty() ? "" : percent_encoded(shown_url);
    if (shown.empty() && names_.size() == 1) shown = percent_encoded(names_.front());
    const std::string last = !has_page_ ? kWebListName : shown.empty() ? "" : "?url=" + shown;
    site.url = base + last;
    for (std::size_t i = 1; i < hosts.size(); ++i) {
      site.other_urls.push_back("http://" + hosts[i] + root_ + last);
    }
    return site;
  }

 private:
  static std::vector<std::string> page_files(const ServeOptions& options) {
    try {
      return web_page_files(options.page_folder);
    } catch (const Error&) {
      if (options.needs_page) throw;
      return {};
    }
  }

  void put(const std::string& name, std::unique_ptr<ServedContent> content) {
    table_[root_ + name] = std::move(content);
  }

  std::string root_;
  SiteTable table_;
  std::vector<std::string> names_;
  bool has_page_ = false;
  bool is_zarr_ = false;
};

std::string host_of(const std::string& address, int port) {
  const bool is_v6 = address.find(':') != std::string::npos;
  const std::string name = is_v6 ? "[" + address + "]" : address;
  return port == 80 ? name : name + ":" + std::to_string(port);
}

}  // namespace

ServeResult serve(const ServeOptions& options, const TaskContext& context) {
  check_origins(options.allowed_origins);
  const std::string token = token_of(options);
  std::vector<std::shared_ptr<FileReader>> volumes;
  for (const std::string& path : options.inputs) {
    if (is_url(path)) {
      throw Error(ErrorKind::invalid_argument, "only files of this machine are served",
                  public_name(path))
          .with_field("serve.inputs");
    }
    volumes.push_back(open_volume(path, context));
    if (const std::string kept = kept_identity_words(*volumes.back());
        !kept.empty() && !options.needs_page) {
      context.warn(path + ": " + kept + ", and is given out as it is");
    }
  }
  Site site(options, token, volumes);
  if (!site.has_page()) context.note("the page of the viewer is not there: files alone are served");

  SiteServerOptions listening;
  listening.address = options.address;
  listening.port = options.port;
  listening.most_workers = static_cast<std::size_t>(context.thread_count());
  SiteServer server(listening);

  SiteRules rules;
  rules.allowed_origins = options.allowed_origins;
  // A page of another name that points here knows no token.
  if (token.empty()) {
    for (const char* name : {"127.0.0.1", "localhost", "::1"}) {
      rules.hosts.push_back(name == std::string_view("localhost")
                                ? name + (":" + std::to_string(server.port()))
                                : host_of(name, server.port()));
    }
    rules.hosts.push_back(host_of(options.address, server.port()));
    if (server.port() == 80) rules.hosts.emplace_back("localhost");
  }
  std::vector<std::string> hosts;
  for (const std::string& address : own_addresses(options.address)) {
    hosts.push_back(host_of(address, server.port()));
  }
  const ServedSite ready = site.at(hosts, server.port(), options.shown_url);
  if (options.on_ready) options.on_ready(ready);
  server.run(rules, site.table(), [&] { return context.watcher().is_cancelled(); });
  context.stop_if_cancelled();
  return {};
}

}  // namespace octavo
