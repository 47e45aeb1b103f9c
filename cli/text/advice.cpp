#include "text/advice.h"

#include <algorithm>
#include <array>
#include <optional>

namespace octavo::cli {

namespace {

struct Advice {
  std::optional<ErrorKind> kind;  ///< nothing: any
  const char* field;
  const char* text;
};

constexpr std::array kAdvice = std::to_array<Advice>({
    {std::nullopt, "input.kind", "'octavo threshold' makes a mask of grey values"},
    {std::nullopt, "max_memory_bytes", "raise --max-memory"},
    {std::nullopt, "output.format", "'octavo export' turns .8vo files into other formats"},
    {ErrorKind::io, "output.overwrite", "--force replaces it"},
    {std::nullopt, "spacing_mm", "build it again with --spacing"},
    {std::nullopt, "tissues", "give --range LOW:HIGH"},
});

}  // namespace

std::string advice_for(const Error& error) {
  const auto found = std::find_if(kAdvice.begin(), kAdvice.end(), [&](const Advice& advice) {
    return error.field() == advice.field && (!advice.kind || *advice.kind == error.kind());
  });
  return found == kAdvice.end() ? "" : found->text;
}

}  // namespace octavo::cli
