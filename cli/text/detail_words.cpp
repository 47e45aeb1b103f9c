#include "text/detail_words.h"

#include <fmt/format.h>

#include "octavo/core/text.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo::cli {

std::string detail_error_words(const VolumeDescription& volume, const DetailErrors& errors) {
  const std::string unit = unit_of(volume).empty() ? "" : " " + unit_of(volume);
  std::string text;
  const auto add = [&](const std::string& words) { text += (text.empty() ? "" : ", ") + words; };
  if (errors.max) add(fmt::format("largest error {}{}", number_text(*errors.max), unit));
  if (errors.rms) add(fmt::format("RMS {:.4g}{}", *errors.rms, unit));
  if (errors.psnr_db) add(fmt::format("PSNR {:.2f} dB", *errors.psnr_db));
  return text;
}

}  // namespace octavo::cli
