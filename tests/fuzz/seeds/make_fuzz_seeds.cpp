// Writes inputs for the fuzz targets to start from: made here, and cut out of a folder of files.
//
// usage: make_fuzz_seeds FILES FOLDER        fills FOLDER/TARGET for every target

#include <algorithm>
#include <iostream>
#include <vector>

#include "fuzz/seeds/seed_folder.h"

int main(int argc, char** argv) {
  using namespace octavo;
  if (argc != 3) {
    std::cerr << "usage: make_fuzz_seeds FILES FOLDER\n";
    return 2;
  }
  fuzz::SeedFolder seeds(argv[2]);
  fuzz::save_metadata(seeds);
  fuzz::save_parts(seeds);
  fuzz::save_streams(seeds);
  fuzz::save_bricks(seeds);
  fuzz::save_files(seeds);
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) {
    if (entry.path().extension() == ".8vo") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  for (const std::filesystem::path& path : paths) fuzz::save_sections(seeds, path);
}
