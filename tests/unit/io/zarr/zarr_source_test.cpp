#include "octavo/io/zarr/zarr_source.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <map>

#include "octavo/io/zarr/zarr_output.h"
#include "octavo/io/zarr/zarr_shard.h"
#include "octavo/file/storage/storage.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

namespace fs = std::filesystem;

using Texts = std::map<std::string, std::string>;  // files by their keys

/// Replaces the one place where `from` stands.
std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

const std::string kMultiscales =
    R"("multiscales":[{"name":"a name","axes":[)"
    R"({"name":"z","type":"space","unit":"micrometer"},)"
    R"({"name":"y","type":"space","unit":"micrometer"},)"
    R"({"name":"x","type":"space","unit":"micrometer"}],"datasets":[{"path":"s0",)"
    R"("coordinateTransformations":[{"type":"scale","scale":[4000,3000,2000]},)"
    R"({"type":"translation","translation":[7000,8000,9000]}]}]}])";

const std::string kArray3 =
    R"({"zarr_format":3,"node_type":"array","shape":[2,3,4],"data_type":"int16",)"
    R"("chunk_grid":{"name":"regular","configuration":{"chunk_shape":[1,2,4]}},)"
    R"("chunk_key_encoding":{"name":"default","configuration":{"separator":"/"}},)"
    R"("fill_value":-5,"codecs":[{"name":"bytes","configuration":{"endian":"little"}}]})";

const std::string kArray2 =
    R"({"zarr_format":2,"shape":[2,3,4],"chunks":[1,2,4],"dtype":"<i2","order":"C",)"
    R"("fill_value":-5,"filters":null,"compressor":null,"dimension_separator":"/"})";

/// The chunk of [1, 2, 4] voxels at plane z, row 2 * y; what lies behind the volume is 99.
std::string chunk_at(int z, int y) {
  std::vector<std::int16_t> values;
  for (int row = 2 * y; row < 2 * y + 2; ++row) {
    for (int x = 0; x < 4; ++x) {
      values.push_back(row < 3 ? kStoredValues[static_cast<std::size_t>(12 * z + 4 * row + x)]
                               : std::int16_t{99});
    }
  }
  return bytes_of(values);
}

std::string packed(const std::string& chunk, ZarrCompression compression) {
  const std::vector<std::uint8_t> bytes =
      packed_chunk({reinterpret_cast<const std::uint8_t*>(chunk.data()), chunk.size()},
                   VoxelType::int16, compression);
  return {bytes.begin(), bytes.end()};
}

template <class Pack>
void add_chunks(Texts& files, const std::string& prefix, const Pack& pack) {
  for (int z = 0; z < 2; ++z) {
    for (int y = 0; y < 2; ++y) {
      files[prefix + std::to_string(z) + "/" + std::to_string(y) + "/0"] = pack(chunk_at(z, y));
    }
  }
}

/// An image of version 3; its array is changed by `edit`.
template <class Pack>
Texts image_of_v3(const std::string& array, const Pack& pack) {
  Texts files = {{"zarr.json", R"({"zarr_format":3,"node_type":"group","attributes":{"ome":{)"
                               R"("version":"0.5",)" + kMultiscales + "}}}"},
                 {"s0/zarr.json", array}};
  add_chunks(files, "s0/c/", pack);
  return files;
}

template <class Pack>
Texts image_of_v2(const std::string& array, const Pack& pack) {
  Texts files = {{".zgroup", R"({"zarr_format":2})"},
                 {".zattrs", "{" + kMultiscales + "}"},
                 {"s0/.zarray", array}};
  add_chunks(files, "s0/", pack);
  return files;
}

std::string as_it_is(const std::string& chunk) { return chunk; }

class ZarrSources : public ::testing::Test {
 protected:
  std::string write(const Texts& files, const std::string& name = "a.ome.zarr") {
    fs::remove_all(folder_.path() + "/" + name);
    for (const auto& [key, bytes] : files) write_file(folder_.file(name + "/" + key), bytes);
    return folder_.path() + "/" + name;
  }

  /// The image of plain chunks in one file.
  std::string write_zip() {
    std::string path = folder_.file("a.ozx");
    const auto zip = make_zarr_zip(local_storage(), path, false);
    for (const auto& [key, bytes] : image_of_v3(kArray3, as_it_is)) {
      zip->put(key, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    }
    zip->finish();
    return path;
  }

  void expect_volume(const std::string& path, const std::string& voxels) {
    const auto source = open_source({path}, {});
    const VolumeDescription& d = source->description();
    EXPECT_EQ(d.size, (Size3{4, 3, 2}));
    EXPECT_EQ(d.type, VoxelType::int16);
    EXPECT_EQ(d.geometry.spacing_mm, (Point3{2, 3, 4}));
    EXPECT_EQ(d.geometry.origin_mm, (Point3{9, 8, 7}));
    EXPECT_TRUE(contains(d.metadata.text(), "\"format\":\"OME-Zarr\"")) << d.metadata.text();
    EXPECT_TRUE(contains(d.metadata.text(), "\"place_known\":false")) << d.metadata.text();
    EXPECT_FALSE(contains(d.metadata.text(), "a name")) << d.metadata.text();
    EXPECT_EQ(voxels_of(*source), voxels);
    EXPECT_TRUE(source->warnings().empty()) << first_warning(*source);
    source->seek(1, 2);
    std::string plane(24, '\0');
    source->read_plane(std::as_writable_bytes(std::span(plane)));
    EXPECT_EQ(plane, voxels.substr(24));
  }

  void expect_rejected(const Texts& files, const std::string& words,
                       ErrorKind kind = ErrorKind::source_rejected) {
    const Error error = source_error({write(files)});
    EXPECT_EQ(error.kind(), kind) << error.what();
    EXPECT_TRUE(contains(error, words)) << error.what();
  }

  TempFolder folder_;
};

struct Coding {
  const char* name;
  std::string v2;  ///< compressor
  std::string v3;  ///< codecs
  std::string (*pack)(const std::string&);
};

TEST_F(ZarrSources, ImagesOfBothVersionsGiveWhatTheirChunksHold) {
  const std::string bytes = R"({"name":"bytes","configuration":{"endian":"little"}})";
  const std::vector<Coding> codings = {
      {"plain", "null", bytes, as_it_is},
      {"zstd", R"({"id":"zstd","level":1})", bytes + R"(,{"name":"zstd","configuration":{}})",
       [](const std::string& chunk) { return packed(chunk, ZarrCompression::zstd); }},
      {"blosc", R"({"id":"blosc"})", bytes + R"(,{"name":"blosc","configuration":{}})",
       [](const std::string& chunk) { return packed(chunk, ZarrCompression::blosc); }},
      {"gzip", R"({"id":"gzip"})", bytes + R"(,{"name":"gzip","configuration":{}})", gzip}};
  for (const Coding& coding : codings) {
    SCOPED_TRACE(coding.name);
    expect_volume(write(image_of_v3(changed(kArray3, bytes, coding.v3), coding.pack)),
                  bytes_of(kStoredValues));
    expect_volume(
        write(image_of_v2(changed(kArray2, "\"compressor\":null", "\"compressor\":" + coding.v2),
                          coding.pack)),
        bytes_of(kStoredValues));
  }
}

TEST_F(ZarrSources, ChunksThatAreMissingHaveTheFillValue) {
  for (Texts files : {image_of_v3(kArray3, as_it_is), image_of_v2(kArray2, as_it_is)}) {
    files.erase(files.contains("s0/1/0/0") ? "s0/1/0/0" : "s0/c/1/0/0");
    std::vector<std::int16_t> expected = kStoredValues;
    std::fill(expected.begin() + 12, expected.begin() + 20, std::int16_t{-5});
    expect_volume(write(files), bytes_of(expected));
  }
}

TEST_F(ZarrSources, MembersThatNeedNotBeUnderstoodAreLeftAlone) {
  for (const char* member : {"\"foo\":{\"must_understand\":false,\"a\":1}",
                             "\"storage_transformers\":[]"}) {
    SCOPED_TRACE(member);
    const std::string array = changed(kArray3, "\"shape\"", std::string(member) + ",\"shape\"");
    expect_volume(write(image_of_v3(array, as_it_is)), bytes_of(kStoredValues));
  }
}

TEST_F(ZarrSources, WhatNeedsNoConfigurationMayBeANameAlone) {
  const std::string keys = R"({"name":"default","configuration":{"separator":"/"}})";
  const std::string array = changed(kArray3, keys, "\"default\"");
  expect_volume(write(image_of_v3(changed(array, "}}]}", "}},\"zstd\"]}"),
                                  [](const std::string& chunk) {
                                    return packed(chunk, ZarrCompression::zstd);
                                  })),
                bytes_of(kStoredValues));
  const std::string bytes = R"({"name":"bytes","configuration":{"endian":"little"}})";
  EXPECT_TRUE(contains(source_error({write(image_of_v3(changed(array, bytes, "\"bytes\""),
                                                       as_it_is))}),
                       "codec bytes does not say the byte order"));
  EXPECT_TRUE(contains(source_error({write(image_of_v3(changed(array, bytes, "\"packbits\""),
                                                       as_it_is))}),
                       "codec \"packbits\" is not read"));
}

TEST_F(ZarrSources, AFolderInThePlaceOfAChunkIsRejected) {
  const std::string image = write(image_of_v3(kArray3, as_it_is));
  fs::remove(image + "/s0/c/0/0/0");
  fs::create_directory(image + "/s0/c/0/0/0");
  EXPECT_TRUE(contains(source_error({image}), "is a folder, and a file was expected"));
}

TEST_F(ZarrSources, ShardsGiveTheirChunks) {
  std::vector<std::vector<std::uint8_t>> chunks;
  for (int z = 0; z < 2; ++z) {
    for (int y = 0; y < 2; ++y) {
      const std::string chunk = chunk_at(z, y);
      chunks.emplace_back(chunk.begin(), chunk.end());
    }
  }
  const std::vector<std::uint8_t> shard = shard_of(chunks);
  const std::string sharded = changed(
      changed(kArray3, "\"chunk_shape\":[1,2,4]", "\"chunk_shape\":[2,4,4]"),
      R"([{"name":"bytes","configuration":{"endian":"little"}}])",
      R"([{"name":"sharding_indexed","configuration":{"chunk_shape":[1,2,4],)"
      R"("codecs":[{"name":"bytes","configuration":{"endian":"little"}}],)"
      R"("index_codecs":[{"name":"bytes","configuration":{"endian":"little"}},)"
      R"({"name":"crc32c"}],"index_location":"end"}}])");
  Texts files = image_of_v3(sharded, as_it_is);
  std::erase_if(files, [](const auto& file) { return contains(file.first, "/c/"); });
  files["s0/c/0/0/0"] = std::string(shard.begin(), shard.end());
  expect_volume(write(files), bytes_of(kStoredValues));
  files["s0/c/0/0/0"][shard.size() - 9] ^= 1;
  expect_rejected(files, "the checksum of the index of the shard is wrong");
  files["s0/c/0/0/0"].resize(20);
  expect_rejected(files, "shorter than its index of 68 bytes");
}

TEST_F(ZarrSources, AZipFileGivesWhatAFolderDoes) {
  write_zip();
  expect_volume(folder_.file("a.ozx"), bytes_of(kStoredValues));
  const std::string whole = read_file(folder_.file("a.ozx"));
  for (std::size_t length = 0; length < whole.size(); length += length < 64 ? 1 : 13) {
    write_file(folder_.file("a.ozx"), whole.substr(0, length));
    EXPECT_EQ(source_error({folder_.file("a.ozx")}).kind(), ErrorKind::source_rejected) << length;
  }
}

TEST_F(ZarrSources, AFlippedBitOfAZipFileNeverGivesOtherVoxels) {
  const std::string path = write_zip();
  const std::string whole = read_file(path);
  int rejected = 0;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    SCOPED_TRACE(at);
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << at % 8));
    write_file(path, damaged);
    try {
      const auto source = open_source({path}, {});
      ASSERT_EQ(voxels_of(*source), bytes_of(kStoredValues));
      ASSERT_EQ(source->description().geometry.spacing_mm, (Point3{2, 3, 4}));
      ASSERT_EQ(source->description().geometry.origin_mm, (Point3{9, 8, 7}));
    } catch (const Error& error) {
      ASSERT_EQ(error.kind(), ErrorKind::source_rejected) << error.what();
      ++rejected;
    }
  }
  // The rest are dates, versions and the comment.
  EXPECT_GT(rejected, static_cast<int>(whole.size()) * 3 / 4);
}

TEST_F(ZarrSources, AZipFileSaysWhichOfItsFilesIsDamaged) {
  const std::string path = write_zip();
  std::string damaged = read_file(path);
  damaged[damaged.find(chunk_at(1, 0))] ^= 1;
  write_file(path, damaged);
  const Error error = source_error({path});
  EXPECT_TRUE(contains(error, "CRC-32")) << error.what();
  EXPECT_EQ(error.path(), path + "/s0/c/1/0/0");
}

TEST_F(ZarrSources, AnArrayWithinAnImageIsTheLevelThatTheImageSays) {
  Texts files = image_of_v3(kArray3, as_it_is);
  files["other/zarr.json"] = kArray3;
  const std::string path = write(files);
  EXPECT_EQ(geometry_of(path + "/s0").spacing_mm, (Point3{2, 3, 4}));
  EXPECT_TRUE(contains(first_warning(*open_source({path + "/other"}, {})), "1 mm assumed"));
  EXPECT_EQ(error_of([&] { open_zarr_source(path, {}, 1); }).field(), "level");
}

TEST_F(ZarrSources, ChannelsAndTimesAreChosen) {
  Texts files = image_of_v2(kArray2, as_it_is);
  files["s0/.zarray"] = changed(changed(kArray2, "\"shape\":[2,3,4]", "\"shape\":[2,3,2,3,4]"),
                                "\"chunks\":[1,2,4]", "\"chunks\":[1,2,1,2,4]");
  files[".zattrs"] = changed(changed(changed(files[".zattrs"], "\"axes\":[",
                                             R"("axes":[{"name":"t"},{"name":"c"},)"),
                                     "[4000,", "[1,1,4000,"),
                             "[7000,", "[0,0,7000,");
  files[".zattrs"].pop_back();
  files[".zattrs"] += R"(,"omero":{"channels":[{"label":"A"},{"label":"GFP"},{"label":"B"}]}})";
  std::erase_if(files, [](const auto& file) { return file.first.ends_with("/0"); });
  // Two channels in a chunk: the one asked for lies behind the other.
  const std::string chunk = std::string(16, '\0') + chunk_at(0, 1);
  files["s0/1/0/0/1/0"] = chunk;
  const std::string path = write(files);
  SourceOptions options;
  EXPECT_EQ(error_of([&] { open_source({path}, options); }).field(), "channel");
  options.channel = "1";
  options.time = 1;
  const std::string voxels = voxels_of(*open_source({path}, options));
  EXPECT_FALSE(contains(open_source({path}, options)->description().metadata.text(), "GFP"));
  options.channel = "GFP";
  EXPECT_EQ(voxels_of(*open_source({path}, options)), voxels);
  EXPECT_EQ(voxels.substr(16, 8), bytes_of(kStoredValues).substr(16, 8));
}

TEST_F(ZarrSources, WhatDoesNotFitIsRejectedWithItsFile) {
  struct Row {
    std::string from;
    std::string to;
    std::string words;
  };
  const std::vector<Row> rows = {
      {"[2,3,4]", "[0,3,4]", "shape has 0"},
      {"[2,3,4]", "[-2,3,4]", "shape has -2"},
      {"[2,3,4]", "[9223372036854775807,3,4]", "shape has 9223372036854775807"},
      {"[2,3,4]", "[2,3]", "chunk_shape must be a list of 2"},
      {"[2,3,4]", "[2,\"3\",4]", "shape must be a list"},
      {"[2,3,4]", "[2147483647,2147483647,2147483647]", "every axis must be"},
      {"[1,2,4]", "[2048,2048,2048]", "more than 1 GiB"},
      {"[1,2,4]", "[2147483647,2147483647,2147483647]", "more than 1 GiB"},
      {"\"int16\"", "\"complex64\"", "voxel type \"complex64\" is not supported"},
      {"\"int16\"", "\"i2\"", "is not supported"},
      {"\"fill_value\":-5", "\"fill_value\":1e9", "fill_value 1e9 is no value"},
      {"\"fill_value\":-5", "\"fill_value\":\"NaN\"", "is no value of the array"},
      {"\"regular\"", "\"rectilinear\"", "chunk_grid \"rectilinear\" is not read"},
      {"\"default\"", "\"odd\"", "chunk_key_encoding \"odd\" is not read"},
      {"\"separator\":\"/\"", "\"separator\":\"../\"", "is not read"},
      {"\"bytes\"", "\"pcodec\"", "codec \"pcodec\" is not read"},
      {"\"little\"", "\"middle\"", "byte order"},
      {"\"zarr_format\":3", "\"zarr_format\":4", "no array of zarr 2 or 3"},
      {"\"node_type\":\"array\"", "\"node_type\":\"group\"", "is no array"},
      {"\"shape\"", "\"foo\":{\"must_understand\":true},\"shape\"", "\"foo\" is not understood"},
      {"\"shape\"", "\"bar\":3,\"shape\"", "\"bar\" is not understood"},
      {"\"shape\"", "\"storage_transformers\":[{\"name\":\"x\"}],\"shape\"",
       "\"storage_transformers\" is not understood"},
      {"\"codecs\":[", "\"codecs\":[[[", "s0/zarr.json"}};
  for (const Row& row : rows) {
    SCOPED_TRACE(row.to);
    const Error error =
        source_error({write(image_of_v3(changed(kArray3, row.from, row.to), as_it_is))});
    EXPECT_TRUE(error.kind() == ErrorKind::source_rejected ||
                error.kind() == ErrorKind::limit_exceeded)
        << error.what();
    EXPECT_TRUE(contains(error, row.words)) << error.what();
    EXPECT_TRUE(contains(error.path(), "a.ome.zarr")) << error.path();
  }
}

TEST_F(ZarrSources, WhatLeadsOutOfTheImageIsRejected) {
  write_file(folder_.file("secret"), chunk_at(0, 0));
  for (const char* path : {"../other", "/etc", "s0/../../x", "", ".", "s0//x"}) {
    Texts files = image_of_v3(kArray3, as_it_is);
    files["zarr.json"] = changed(files["zarr.json"], "\"path\":\"s0\"",
                                 "\"path\":\"" + std::string(path) + "\"");
    expect_rejected(files, "does not lie in the image");
  }
  const std::string image = write(image_of_v3(kArray3, as_it_is));
  for (const std::string& target : {folder_.file("secret"), std::string("/dev/zero")}) {
    fs::remove(image + "/s0/c/0/0/0");
    fs::create_symlink(target, image + "/s0/c/0/0/0");
    EXPECT_TRUE(contains(source_error({image}), "leads out of the folder"));
  }
}

TEST_F(ZarrSources, ChunksOfAnotherLengthAreRejected) {
  for (const std::size_t bytes : {0U, 1U, 15U, 17U, 40U}) {
    Texts files = image_of_v3(kArray3, as_it_is);
    files["s0/c/1/1/0"] = std::string(bytes, 'x');
    expect_rejected(files, "a chunk has " + std::to_string(bytes) + " bytes, 16 expected");
  }
}

TEST_F(ZarrSources, GroupsWithoutAnImageSayWhatToName) {
  const auto group = [](const std::string& ome) {
    return Texts{{"zarr.json", R"({"zarr_format":3,"node_type":"group","attributes":{"ome":{)" +
                                   ome + "}}}"}};
  };
  expect_rejected(group(R"("plate":{"wells":[]})"), "a.ome.zarr/A/1/0");
  expect_rejected(group(R"("bioformats2raw.layout":3)"), "holds several images");
  expect_rejected(group(R"("version":"0.5")"), "without an OME-Zarr image");
}

TEST_F(ZarrSources, ALayerLargerThanTheMemoryLimitIsRejected) {
  SourceOptions options;
  options.max_memory_bytes = 23;
  const std::string path = write(image_of_v3(kArray3, as_it_is));
  const Error error = error_of([&] { open_source({path}, options); });
  EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
  EXPECT_TRUE(contains(error, "24 bytes")) << error.what();
}

}  // namespace
}  // namespace octavo::testing
