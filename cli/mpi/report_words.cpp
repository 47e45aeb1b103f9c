#include "mpi/report_words.h"

#include <fmt/format.h>

#include "text/fact_json.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

// Of the thesis, for lambda = 1/2 and 4 workers (2.8), and of what is held besides (2.9).
constexpr double kSentShare = 1.0 / 16;
constexpr double kHeldShare = 3.0 / 4;

std::string share_text(double part, double whole) {
  if (part <= 0 || whole <= 0) return "0";
  const double inverse = whole / part;
  return inverse < 2 ? fmt::format("{:.2f}", 1 / inverse) : fmt::format("1/{:.0f}", inverse);
}

}  // namespace

std::string report_text(const RankReport& report, const ReportUnits& units) {
  const auto codes = static_cast<double>(report.codes());
  const auto sent = static_cast<double>(report.codes_sent());
  std::string text = fmt::format("ranks     {}, gather by {}\n\n  {:>5}  {:>16}  {:>13}\n",
                                 report.ranks.size(), word_of(report.gather), "level", "codes",
                                 "sent");
  for (const LevelTraffic& row : report.levels) {
    text += fmt::format("  {:>5}  {:>16}  {:>13}\n", row.level,
                        count_text(static_cast<std::int64_t>(row.codes)),
                        count_text(static_cast<std::int64_t>(row.sent)));
  }
  text += fmt::format("  {:>5}  {:>16}  {:>13}\n\n", "all",
                      count_text(static_cast<std::int64_t>(report.codes())),
                      count_text(static_cast<std::int64_t>(report.codes_sent())));
  text += fmt::format("sent      {} of B codes, {}; thesis 2.8: B/16 = {} codes\n",
                      share_text(sent, codes), bytes_text(report.bytes_sent()),
                      count_text(static_cast<std::int64_t>(codes * kSentShare)));
  const auto held = static_cast<double>(report.held());
  text += fmt::format("held      {} {} besides, {} of the whole; thesis 2.9: at most 3/4 of it\n",
                      count_text(static_cast<std::int64_t>(held)), units.held,
                      share_text(held, units.whole));
  const auto count = static_cast<double>(report.ranks.size());
  text += fmt::format(
      "speed-up  {:.2f} by processor time ({:.0f} % of {}); thesis 2.8: time 1/{}\n\n",
      report.speed_up(), 100 * report.speed_up() / count, report.ranks.size(),
      report.ranks.size());
  text += fmt::format("  {:>5}  {:>8}  {:>13}  {:>10}\n", "rank", units.units, "sent bytes",
                      "CPU s");
  for (std::size_t rank = 0; rank < report.ranks.size(); ++rank) {
    const RankShare& share = report.ranks[rank];
    text += fmt::format("  {:>5}  {:>8}  {:>13}  {:>10.2f}\n", rank, share.units,
                        count_text(static_cast<std::int64_t>(share.message_bytes)),
                        share.processor_seconds);
  }
  return text;
}

nlohmann::ordered_json report_json(const RankReport& report, const ReportUnits& units) {
  const auto codes = static_cast<double>(report.codes());
  const auto level_json = [](const LevelTraffic& row) -> nlohmann::ordered_json {
    return {{"level", row.level}, {"codes", row.codes}, {"sent", row.sent}};
  };
  const auto share_json = [&](const RankShare& share) -> nlohmann::ordered_json {
    return {{units.units, share.units},
            {"sent_bytes", share.message_bytes},
            {"held_" + units.held, share.held},
            {"processor_seconds", share.processor_seconds}};
  };
  const auto count = static_cast<double>(report.ranks.size());
  return {{"ranks", report.ranks.size()},
          {"gather", word_of(report.gather)},
          {"levels", json_list(report.levels, level_json)},
          {"codes", report.codes()},
          {"codes_sent", report.codes_sent()},
          {"codes_sent_thesis", codes * kSentShare},
          {"bytes_sent", report.bytes_sent()},
          {"held_" + units.held, report.held()},
          {"held_thesis", units.whole * kHeldShare},
          {"speed_up", report.speed_up()},
          {"speed_up_thesis", count},
          {"shares", json_list(report.ranks, share_json)}};
}

}  // namespace octavo::cli
