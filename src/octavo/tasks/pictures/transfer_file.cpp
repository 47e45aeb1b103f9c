#include "octavo/tasks/pictures/transfer_file.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "octavo/core/error.h"
#include "octavo/core/json_reader.h"
#include "octavo/core/text.h"
#include "octavo/file/storage/storage.h"
#include "octavo/tasks/pictures/color_names.h"

namespace octavo {

namespace {

constexpr std::uint64_t kMostTransferBytes = std::uint64_t{1} << 20;
constexpr double kThickestLayerMm = 1e6;
constexpr double kFarthestValue = 1e38;  // differences of two are finite

[[noreturn]] void fail_transfer(const std::string& what) {
  throw Error(ErrorKind::invalid_argument, "no transfer function: " + what);
}

double transfer_number(JsonReader& in, const std::string& what) {
  const JsonToken token = in.next();
  const bool is_number = token == JsonToken::integer || token == JsonToken::number;
  if (!is_number || !in.number() || !std::isfinite(*in.number())) {
    fail_transfer(what + " is not a finite number");
  }
  return *in.number();
}

TransferPoint transfer_point(JsonReader& in, std::size_t number) {
  const std::string which = fmt::format("point {}", number);
  if (in.token() != JsonToken::begin_object) fail_transfer(which + " is not an object");
  std::optional<double> value;
  std::optional<double> opacity;
  std::optional<Color> color;
  while (in.next() == JsonToken::name) {
    const std::string name = in.string();
    if (name == "value") {
      value = transfer_number(in, which + ": value");
      if (!(std::abs(*value) <= kFarthestValue)) {
        fail_transfer(fmt::format("{}: a value of {}; expected -1e38 to 1e38", which,
                                  number_text(*value)));
      }
    } else if (name == "opacity") {
      opacity = transfer_number(in, which + ": opacity");
      if (!(*opacity >= 0 && *opacity <= 1)) {
        fail_transfer(fmt::format("{}: an opacity of {}; expected 0 to 1", which,
                                  number_text(*opacity)));
      }
    } else if (name == "color") {
      if (in.next() == JsonToken::string) color = find_color(in.string());
      if (!color) {
        fail_transfer(fmt::format("{}: the color {}; expected \"#rrggbb\" or one of {}", which,
                                  escaped(in.written()), color_names()));
      }
    } else {
      fail_transfer(fmt::format("{}: the member \"{}\"; expected value, color and opacity", which,
                                escaped(name)));
    }
  }
  if (!value || !color || !opacity) {
    fail_transfer(which + " needs a value, a color and an opacity");
  }
  return {*value, *color, *opacity};
}

std::vector<TransferPoint> transfer_points(JsonReader& in) {
  if (in.next() != JsonToken::begin_list) fail_transfer("points is not a list");
  std::vector<TransferPoint> points;
  while (in.next() != JsonToken::end_list) {
    points.push_back(transfer_point(in, points.size() + 1));
    if (points.size() > 1 && points.back().value < points[points.size() - 2].value) {
      fail_transfer(fmt::format("the value of point {} is below that of the one before it",
                                points.size()));
    }
  }
  return points;
}

GradientRamp gradient_ramp(JsonReader& in) {
  if (in.next() != JsonToken::begin_list) fail_transfer("gradient is not a list");
  GradientRamp ramp;
  ramp.low = transfer_number(in, "gradient");
  ramp.high = transfer_number(in, "gradient");
  if (in.next() != JsonToken::end_list) fail_transfer("gradient has more than two numbers");
  if (!(ramp.low >= 0 && ramp.high > ramp.low)) {
    fail_transfer("gradient does not rise from 0 or more");
  }
  return ramp;
}

TransferFunction transfer_object(JsonReader& in) {
  if (in.next() != JsonToken::begin_object) fail_transfer("it is not an object");
  TransferFunction transfer;
  while (in.next() == JsonToken::name) {
    const std::string name = in.string();
    if (name == "points") {
      transfer.points = transfer_points(in);
    } else if (name == "layer_mm") {
      transfer.layer_mm = transfer_number(in, "layer_mm");
      if (!(*transfer.layer_mm > 0 && *transfer.layer_mm <= kThickestLayerMm)) {
        fail_transfer("layer_mm is not above 0 and at most 1e6");
      }
    } else if (name == "relative") {
      if (in.next() != JsonToken::boolean) fail_transfer("relative is neither true nor false");
      transfer.is_relative = in.boolean();
    } else if (name == "gradient") {
      transfer.gradient = gradient_ramp(in);
    } else {
      fail_transfer(fmt::format("the member \"{}\"; expected points, layer_mm, relative and "
                                "gradient",
                                escaped(name)));
    }
  }
  if (in.next() != JsonToken::end) fail_transfer("something follows it");
  if (transfer.points.empty()) fail_transfer("it has no points");
  return transfer;
}

}  // namespace

TransferFunction parse_transfer(std::string_view text) {
  JsonReader in(text);
  try {
    return transfer_object(in);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::invalid_argument) throw;
    fail_transfer(error.detail());
  }
}

TransferFunction read_transfer(const std::string& name_or_path) {
  if (const auto preset = find_transfer_preset(name_or_path)) return *preset;
  try {
    const std::shared_ptr<const ByteSource> file =
        open_byte_source(local_storage(), name_or_path);
    if (file->size() > kMostTransferBytes) {
      throw Error(ErrorKind::invalid_argument, "no transfer function: it is above 1 MiB");
    }
    Bytes bytes(static_cast<std::size_t>(file->size()));
    file->read(0, bytes);
    return parse_transfer({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  } catch (const Error& error) {
    const bool is_missing = error.kind() == ErrorKind::io;
    const Error with_names =
        is_missing ? error.with_detail(error.detail() + "; presets are " + transfer_preset_names())
                   : error;
    throw with_names.with_path(name_or_path);
  }
}

std::string transfer_preset_names() {
  std::string names;
  for (const TransferPreset& preset : transfer_presets()) {
    names += (names.empty() ? "" : ", ") + std::string(preset.name);
  }
  return names;
}

}  // namespace octavo
