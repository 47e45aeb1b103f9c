#include "common/progress_line.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "text/quantities.h"

namespace octavo::cli {

namespace {

// Short work shows nothing at all.
constexpr auto kFirstBar = std::chrono::milliseconds(300);
constexpr auto kFirstPlainLine = std::chrono::seconds(2);
constexpr auto kBarPeriod = std::chrono::milliseconds(100);
constexpr auto kJsonPeriod = std::chrono::milliseconds(500);

ProgressMode resolved_mode(const Context& context) {
  if (context.progress != ProgressMode::automatic) return context.progress;
  if (context.quiet) return ProgressMode::none;
  return isatty(STDERR_FILENO) ? ProgressMode::bar : ProgressMode::plain;
}

int terminal_columns() {
  winsize window = {};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &window) != 0 || window.ws_col == 0) return 80;
  return window.ws_col;
}

std::string amount_text(std::int64_t amount, const std::string& unit) {
  if (unit == "bytes") return bytes_text(static_cast<std::uint64_t>(amount));
  return count_text(amount);
}

std::string rate_text(double per_second, const std::string& unit) {
  if (unit == "bytes") return bytes_text(static_cast<std::uint64_t>(per_second)) + "/s";
  if (per_second < 1) return fmt::format("{:.2g} {}/s", per_second, unit);
  if (per_second < 10) return fmt::format("{:.1f} {}/s", per_second, unit);
  return fmt::format("{:.0f} {}/s", per_second, unit);
}

void write_error_stream(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

ProgressLine::ProgressLine(const Context& context) : mode_(resolved_mode(context)) {}

ProgressLine::~ProgressLine() { erase_bar(); }

void ProgressLine::begin(std::string_view what, std::int64_t total, std::string_view unit) {
  const std::lock_guard lock(mutex_);
  what_ = what;
  unit_ = unit;
  total_ = std::max<std::int64_t>(total, 0);
  done_ = 0;
  shown_tenth_ = 0;
  start_ = shown_ = Clock::now();
  is_running_ = true;
}

void ProgressLine::advance(std::int64_t units) {
  const std::lock_guard lock(mutex_);
  if (!is_running_) return;
  done_ = std::min(done_ + units, total_);
  const auto now = Clock::now();
  if (is_due(now)) show(now);
}

void ProgressLine::end() {
  const std::lock_guard lock(mutex_);
  if (!is_running_) return;
  if (mode_ == ProgressMode::json) show(Clock::now());
  erase_bar();
  is_running_ = false;
}

bool ProgressLine::is_due(Clock::time_point now) const {
  switch (mode_) {
    case ProgressMode::bar: return now - start_ >= kFirstBar && now - shown_ >= kBarPeriod;
    case ProgressMode::plain:
      return total_ > 0 && done_ * 10 / total_ > shown_tenth_ && now - start_ >= kFirstPlainLine;
    case ProgressMode::json: return now - shown_ >= kJsonPeriod;
    default: return false;
  }
}

void ProgressLine::show(Clock::time_point now) {
  const double seconds = std::chrono::duration<double>(now - start_).count();
  shown_ = now;
  if (total_ > 0) shown_tenth_ = done_ * 10 / total_;
  if (mode_ == ProgressMode::json) {
    write_error_stream(json_text(seconds) + "\n");
  } else if (mode_ == ProgressMode::plain) {
    write_error_stream(plain_text(seconds) + "\n");
  } else {
    write_error_stream("\r" + bar_text(seconds) + "\033[K");
    is_bar_visible_ = true;
  }
}

void ProgressLine::erase_bar() {
  if (is_bar_visible_) write_error_stream("\r\033[K");
  is_bar_visible_ = false;
}

std::string ProgressLine::plain_text(double seconds) const {
  const double share = total_ > 0 ? static_cast<double>(done_) / static_cast<double>(total_) : 0;
  const double per_second = seconds > 0 ? static_cast<double>(done_) / seconds : 0;
  std::string text = fmt::format("octavo: {} {:3.0f} %  {} of {}{}", what_,
                                 std::floor(share * 100), amount_text(done_, unit_),
                                 amount_text(total_, unit_), unit_ == "bytes" ? "" : " " + unit_);
  if (per_second > 0) text += "  " + rate_text(per_second, unit_);
  if (per_second > 0 && done_ < total_) {
    const double left = static_cast<double>(total_ - done_) / per_second;
    text += "  " + duration_text(std::max(1.0, std::round(left))) + " left";
  }
  return text;
}

std::string ProgressLine::bar_text(double seconds) const {
  const std::string text = plain_text(seconds).substr(std::string("octavo: ").size());
  const int room = terminal_columns() - static_cast<int>(text.size()) - 4;
  if (room < 10)
    return text.substr(0, static_cast<std::size_t>(std::max(0, terminal_columns() - 1)));
  const int width = std::min(room, 40);
  const int full = total_ > 0 ? static_cast<int>(done_ * width / total_) : 0;
  return fmt::format("[{:=<{}}{:<{}}]  {}", "", full, "", width - full, text);
}

std::string ProgressLine::json_text(double seconds) const {
  const double per_second = seconds > 0 ? static_cast<double>(done_) / seconds : 0;
  nlohmann::ordered_json object = {{"what", what_},       {"done", done_},
                                   {"total", total_},     {"unit", unit_},
                                   {"seconds", seconds},  {"per_second", per_second},
                                   {"seconds_left", nullptr}};
  if (per_second > 0) object["seconds_left"] = static_cast<double>(total_ - done_) / per_second;
  return nlohmann::ordered_json{{"progress", object}}.dump();
}

}  // namespace octavo::cli
