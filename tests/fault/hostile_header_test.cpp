// Crafted headers: every field of every kept file with extreme values, alone and in pairs, under
// checksums that fit. Opening ends soon and needs little memory, whatever the header says.
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>

#include "fault/reseal.h"
#include "octavo/file/verify.h"
#include "support/counted_memory.h"
#include "support/goal_cases.h"
#include "support/sample_file.h"
#include "support/source_folder.h"

namespace octavo {
namespace {

namespace fs = std::filesystem;
using namespace octavo::testing;

constexpr double kMostOpenMs = 100;

struct Field {
  std::size_t at = 0;
  std::size_t width = 0;
};

// Every field of the header but its magic and its checksum, which is made anew.
std::vector<Field> header_fields() {
  std::vector<Field> fields = {{8, 2}, {10, 2}, {12, 1}, {13, 1}, {14, 1}, {15, 1}};
  for (std::size_t at = 16; at < 48; ++at) fields.push_back({at, 1});
  for (std::size_t at = 48; at < 232; at += 8) fields.push_back({at, 8});
  for (std::size_t section = 232; section < 328; section += 24) {
    fields.push_back({section, 8});
    fields.push_back({section + 8, 8});
    fields.push_back({section + 16, 4});
    fields.push_back({section + 20, 4});
  }
  fields.push_back({328, 4});
  fields.push_back({332, 2});
  fields.push_back({334, 2});
  fields.push_back({336, 1});
  fields.push_back({337, 8});
  fields.push_back({345, 8});
  fields.push_back({353, 8});
  return fields;
}

std::uint64_t bits_of(double value) {
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

const std::vector<std::uint64_t>& values() {
  using Limits = std::numeric_limits<double>;
  static const std::vector<std::uint64_t> all = {
      0, 1, 2, 0x7f, 0x80, 0xff, 0x7fff, 0x8000, 0xffff, std::uint64_t{1} << 21,
      (std::uint64_t{1} << 21) + 1, (std::uint64_t{1} << 31) - 1, std::uint64_t{1} << 31,
      (std::uint64_t{1} << 32) - 1, std::uint64_t{1} << 32, std::uint64_t{1} << 62,
      (std::uint64_t{1} << 63) - 1, std::uint64_t{1} << 63, ~std::uint64_t{0} - 1,
      ~std::uint64_t{0}, bits_of(Limits::quiet_NaN()), bits_of(Limits::infinity()),
      bits_of(Limits::denorm_min()), bits_of(Limits::max()), bits_of(-1.0), bits_of(1e-300)};
  return all;
}

void put(std::vector<std::uint8_t>& bytes, const Field& field, std::uint64_t value) {
  for (std::size_t i = 0; i < field.width; ++i) {
    bytes[field.at + i] = static_cast<std::uint8_t>(value >> 8 * i);
  }
}

double cpu_ms() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) / 1e6;
}

struct Kept {
  std::string name;
  std::vector<std::uint8_t> bytes;
  FileHeader layout;
};

std::vector<Kept> kept_files() {
  std::vector<Kept> files;
  for (const auto& entry : fs::directory_iterator(source_folder() + "/tests/golden/v1")) {
    if (entry.path().extension() != ".8vo") continue;
    std::ifstream in(entry.path(), std::ios::binary);
    Kept file;
    file.name = entry.path().filename().string();
    file.bytes.assign(std::istreambuf_iterator<char>(in), {});
    file.layout = header_of(file.bytes);
    files.push_back(std::move(file));
  }
  std::sort(files.begin(), files.end(),
            [](const Kept& a, const Kept& b) { return a.name < b.name; });
  return files;
}

// What the crafted files cost.
struct Costs {
  double slowest_ms = 0;
  std::size_t most_bytes = 0;
  std::uint64_t rejected = 0;
  std::uint64_t read = 0;

  std::string text() const {
    char line[160];
    std::snprintf(line, sizeof line,
                  "%llu rejected; slowest open %.2f ms, most memory beyond the file %.2f MiB",
                  static_cast<unsigned long long>(rejected), slowest_ms,
                  static_cast<double>(most_bytes) / (1 << 20));
    return line;
  }
};

// Opens `bytes`, and reads and verifies what opens.
void exercise(const std::vector<std::uint8_t>& bytes, Costs& costs, const std::string& what) {
  const auto source = byte_source_of(bytes, "crafted.8vo");
  const std::size_t before = live_bytes();
  reset_peak();
  const double began = cpu_ms();
  std::shared_ptr<FileReader> reader;
  try {
    reader = FileReader::open(source);
  } catch (const Error&) {
    ++costs.rejected;
  }
  const double spent = cpu_ms() - began;
  costs.slowest_ms = std::max(costs.slowest_ms, spent);
  ASSERT_LE(spent, kMostOpenMs) << what;
  for (int level = 0; reader && level < reader->levels().count(); ++level) {
    try {
      read_samples(*reader, {{0, 0, 0}, {1, 1, 1}}, level);
      ++costs.read;
    } catch (const Error&) {
      continue;
    }
  }
  const std::size_t most = peak_bytes() - before;
  costs.most_bytes = std::max(costs.most_bytes, most);
  ASSERT_LE(most, (std::size_t{64} << 20) + 2 * bytes.size()) << what;
}

TEST(HostileHeader, AnyFieldMayHoldAnything) {
  const std::vector<Kept> files = kept_files();
  const std::vector<Field> fields = header_fields();
  ASSERT_GE(files.size(), 10u);
  const std::uint64_t all = files.size() * fields.size() * values().size();
  // Every so manieth of all; a prime, so that none of the three is left out.
  const std::uint64_t step = is_full_form() ? 1 : 7;
  Costs costs;
  GoalCases cases("C1", "headers with one crafted field", (all + step - 1) / step);
  for (std::uint64_t i = 0; cases.next(); i += step) {
    const Field& field = fields[i % fields.size()];
    const std::uint64_t value = values()[i / fields.size() % values().size()];
    const Kept& file = files[i / fields.size() / values().size()];
    std::vector<std::uint8_t> bytes = file.bytes;
    put(bytes, field, value);
    reseal(bytes, file.layout);
    exercise(bytes, costs, file.name + " byte " + std::to_string(field.at));
    if (HasFatalFailure()) return;
  }
  cases.tell(costs.text());
  EXPECT_GT(costs.rejected, 0u);
  EXPECT_GT(costs.read, 0u);
}

TEST(HostileHeader, SeveralFieldsMayHoldAnything) {
  const std::vector<Kept> files = kept_files();
  const std::vector<Field> fields = header_fields();
  std::mt19937_64 random(31);
  Costs costs;
  GoalCases cases("C1", "headers with two to four crafted fields", case_count(2000, 200'000));
  while (cases.next()) {
    const Kept& file = files[random() % files.size()];
    std::vector<std::uint8_t> bytes = file.bytes;
    std::string what = file.name;
    for (std::uint64_t count = 2 + random() % 3; count > 0; --count) {
      const Field& field = fields[random() % fields.size()];
      // Half of the values are near what stands there, to get past one check after another.
      std::uint64_t value = values()[random() % values().size()];
      if (random() % 2 == 0) value = bytes[field.at] + random() % 5 - 2;
      put(bytes, field, value);
      what += ", " + std::to_string(value) + " at " + std::to_string(field.at);
    }
    reseal(bytes, file.layout);
    exercise(bytes, costs, what);
    if (HasFatalFailure()) return;
  }
  cases.tell(costs.text());
}

}  // namespace
}  // namespace octavo
