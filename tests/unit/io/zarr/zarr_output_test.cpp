#include "octavo/io/zarr/zarr_output.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "octavo/core/error.h"

namespace octavo {
namespace {

namespace fs = std::filesystem;

class ZarrOutputs : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("octavo-zarr-" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  void write(const std::string& name) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(path(name)) << "{}";
  }

  void write_image(const std::string& name) const {
    for (const char* key :
         {"zarr.json", "0/zarr.json", "0/c/0/0/0", "0/c/0/12/3", "10/zarr.json"}) {
      write(name + "/" + key);
    }
  }

  static void put_all(ZarrOutput& output) {
    const std::array<std::uint8_t, 3> bytes = {1, 2, 3};
    output.put("zarr.json", bytes);
    output.put("0/c/0/0/7", bytes);
    output.finish();
  }

  std::vector<std::string> hidden_names() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with('.')) names.push_back(name);
    }
    return names;
  }

  fs::path folder_;
};

TEST_F(ZarrOutputs, ReplaceImages) {
  write_image("image.zarr");
  put_all(*make_zarr_folder(local_storage(), path("image.zarr"), true));
  EXPECT_TRUE(fs::exists(path("image.zarr/0/c/0/0/7")));
  EXPECT_FALSE(fs::exists(path("image.zarr/0/c/0/0/0")));
  EXPECT_TRUE(hidden_names().empty());
}

TEST_F(ZarrOutputs, ReplaceNothingElseThatLiesInAnImage) {
  for (const std::string other : {"scan.8vo", "labels/zarr.json", "0/notes", "0/c/scan.8vo",
                                  "0/c/0/scan.8vo", "0/c/0/0/scan.8vo", "0/c/0/0/1/scan.8vo"}) {
    write_image("image.zarr");
    write("image.zarr/" + other);
    EXPECT_THROW(put_all(*make_zarr_folder(local_storage(), path("image.zarr"), true)), Error)
        << other;
    EXPECT_TRUE(fs::exists(path("image.zarr/" + other))) << other;
    EXPECT_TRUE(fs::exists(path("image.zarr/0/c/0/12/3"))) << other;
    EXPECT_TRUE(hidden_names().empty()) << other;
    fs::remove_all(path("image.zarr"));
  }
}

TEST_F(ZarrOutputs, ReplaceNoImageThatHoldsALink) {
  write_image("image.zarr");
  write("elsewhere/0/0");
  fs::create_directory_symlink(path("elsewhere"), path("image.zarr/3"));
  EXPECT_THROW(make_zarr_folder(local_storage(), path("image.zarr"), true), Error);
  EXPECT_TRUE(fs::exists(path("elsewhere/0/0")));
}

TEST_F(ZarrOutputs, RemoveWhatAKilledExportLeft) {
  write_image(".image.zarr.tmp-2147483001");
  write_image(".image.zarr.tmp-2147483002");
  write(".image.zarr.tmp-2147483002/precious");
  write_image(".other.zarr.tmp-2147483003");
  put_all(*make_zarr_folder(local_storage(), path("image.zarr"), false));
  EXPECT_FALSE(fs::exists(path(".image.zarr.tmp-2147483001")));
  EXPECT_TRUE(fs::exists(path(".image.zarr.tmp-2147483002/precious")));
  EXPECT_TRUE(fs::exists(path(".other.zarr.tmp-2147483003/zarr.json")));
}

TEST_F(ZarrOutputs, LeaveWhatAnotherExportIsWriting) {
  const auto slower = make_zarr_folder(local_storage(), path("image.zarr"), true);
  const std::array<std::uint8_t, 1> bytes = {1};
  slower->put("zarr.json", bytes);
  put_all(*make_zarr_folder(local_storage(), path("image.zarr"), true));
  slower->finish();
  EXPECT_FALSE(fs::exists(path("image.zarr/0")));
  EXPECT_TRUE(hidden_names().empty());
}

TEST_F(ZarrOutputs, OfOneFileRejectAFolderBeforeAnythingIsWritten) {
  fs::create_directory(path("image.ozx"));
  EXPECT_THROW(make_zarr_zip(local_storage(), path("image.ozx"), true), Error);
  EXPECT_TRUE(hidden_names().empty());
}

}  // namespace
}  // namespace octavo
