// Runs a fuzz target over files: what a fuzzing engine does with a corpus, in a build without one.
//
// usage: run_corpus TARGET PATH...        PATH: an input, or a folder of inputs

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

extern "C" {
#define X(name) int fuzz_##name(const std::uint8_t* data, std::size_t size);
FUZZ_TARGETS
#undef X
}

namespace {

using Run = int (*)(const std::uint8_t*, std::size_t);

struct Target {
  std::string_view name;
  Run run;
};

constexpr Target kTargets[] = {
#define X(name) {#name, fuzz_##name},
    FUZZ_TARGETS
#undef X
};

Run find_target(std::string_view name) {
  for (const Target& target : kTargets) {
    if (target.name == name) return target.run;
  }
  return nullptr;
}

std::vector<std::filesystem::path> inputs_of(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return {path};
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    if (entry.is_regular_file()) paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::vector<std::uint8_t> bytes_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error("cannot be read: " + path.string());
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

int main(int argc, char** argv) {
  const Run run = argc > 2 ? find_target(argv[1]) : nullptr;
  if (run == nullptr) {
    std::cerr << "usage: run_corpus TARGET PATH...\ntargets:";
    for (const Target& target : kTargets) std::cerr << ' ' << target.name;
    std::cerr << '\n';
    return 2;
  }
  std::size_t count = 0;
  for (int i = 2; i < argc; ++i) {
    for (const std::filesystem::path& path : inputs_of(argv[i])) {
      std::cout << path.string() << std::endl;  // at once: the last one is the one that fails
      const std::vector<std::uint8_t> bytes = bytes_of(path);
      run(bytes.data(), bytes.size());
      ++count;
    }
  }
  std::cout << count << " inputs\n";
  return count > 0 ? 0 : 1;
}
