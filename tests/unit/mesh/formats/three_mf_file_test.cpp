#include <gtest/gtest.h>
#include <zlib.h>

#include <map>

#include "octavo/core/error.h"
#include "unit/mesh/formats/written_mesh.h"

namespace octavo {
namespace {

using testing::kWritten;
using testing::number_in;
using testing::Parts;
using testing::written;

/// The entries of a zip archive by their names, read from the front.
std::map<std::string, std::string> zip_entries(const std::string& zip) {
  constexpr std::size_t kHeadBytes = 30;
  std::map<std::string, std::string> entries;
  std::size_t at = 0;
  while (number_in<std::uint32_t>(zip, at) == 0x04034b50) {
    const auto crc = number_in<std::uint32_t>(zip, at + 14);
    const auto packed_bytes = number_in<std::uint32_t>(zip, at + 18);
    const auto bytes = number_in<std::uint32_t>(zip, at + 22);
    const auto name_bytes = number_in<std::uint16_t>(zip, at + 26);
    const auto extra_bytes = number_in<std::uint16_t>(zip, at + 28);
    const std::string name = zip.substr(at + kHeadBytes, name_bytes);
    std::string packed =
        zip.substr(at + kHeadBytes + name_bytes + extra_bytes, packed_bytes);
    std::string entry(bytes, '\0');
    z_stream stream{};
    inflateInit2(&stream, -MAX_WBITS);
    stream.next_in = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_in = packed_bytes;
    stream.next_out = reinterpret_cast<Bytef*>(entry.data());
    stream.avail_out = bytes;
    EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END) << name;
    inflateEnd(&stream);
    EXPECT_EQ(crc32(0, reinterpret_cast<const Bytef*>(entry.data()), bytes), crc) << name;
    entries[name] = entry;
    at += kHeadBytes + name_bytes + extra_bytes + packed_bytes;
  }
  EXPECT_EQ(number_in<std::uint32_t>(zip, at), 0x02014b50u) << "the directory follows";
  return entries;
}

std::string model_of(const MeshDescription& described) {
  return zip_entries(written(MeshFormat::three_mf, described)).at("3D/3dmodel.model");
}

TEST(ThreeMfFile, SaysWhatItsEntriesAre) {
  const auto entries = zip_entries(written(MeshFormat::three_mf, {.mesh = kWritten}));
  ASSERT_EQ(entries.size(), 3u);
  EXPECT_NE(entries.at("[Content_Types].xml").find("3dmanufacturing-3dmodel+xml"),
            std::string::npos);
  EXPECT_NE(entries.at("_rels/.rels").find("Target=\"/3D/3dmodel.model\""), std::string::npos);
}

TEST(ThreeMfFile, HoldsPointsAndTrianglesInMillimeters) {
  const std::string model = model_of({.mesh = kWritten});
  EXPECT_NE(model.find("unit=\"millimeter\""), std::string::npos);
  EXPECT_NE(model.find("<object id=\"2\" type=\"model\" name=\"surface\">\n<mesh>\n<vertices>\n"
                       "<vertex x=\"0.5\" y=\"-2\" z=\"3\"/>\n"
                       "<vertex x=\"0\" y=\"1e-07\" z=\"0\"/>\n"
                       "<vertex x=\"1\" y=\"0\" z=\"0.1\"/>\n<vertex x=\"0\" y=\"0\" z=\"1\"/>\n"
                       "</vertices>\n<triangles>\n<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>\n"
                       "<triangle v1=\"0\" v2=\"2\" v3=\"3\"/>\n</triangles>"),
            std::string::npos);
  EXPECT_NE(model.find("<item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 0 2 0\"/>"),
            std::string::npos);
}

TEST(ThreeMfFile, KeepsWhatFloatsFarFrom0Are) {
  const TriangleMesh mesh = {{{1000001.375f, 0, 0}, {1000002, 1, 0}, {1000003, 0, 1}}, {{0, 1, 2}}};
  const std::string model = model_of({.mesh = mesh});
  EXPECT_NE(model.find("<vertex x=\"1000001.375\" y=\"0\" z=\"0\"/>"), std::string::npos);
  EXPECT_NE(model.find("transform=\"1 0 0 0 1 0 0 0 1 -1000001.375 0 0\""), std::string::npos);
}

TEST(ThreeMfFile, HasAnObjectWithNameAndColorForEachPart) {
  const Parts with;
  const std::string model = model_of({.mesh = kWritten, .parts = with.parts});
  const std::string name = "left lung &quot;&lt;&amp;\xc3\xa4&gt;&quot;";
  EXPECT_NE(model.find("<base name=\"" + name + "\" displaycolor=\"#0102FF\"/>"),
            std::string::npos);
  EXPECT_NE(model.find("name=\"" + name + "\" pid=\"1\" pindex=\"0\">"), std::string::npos);
  EXPECT_NE(model.find("<object id=\"3\" type=\"model\" name=\"label 300\" pid=\"1\" pindex=\"1\">"
                       "\n<mesh>\n<vertices>\n<vertex x=\"0.5\""),
            std::string::npos);
  EXPECT_NE(model.find("<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>\n</triangles>\n</mesh>\n</object>\n"
                       "</resources>"),
            std::string::npos);
}

TEST(ThreeMfFile, WithoutTrianglesHasNoObject) {
  const TriangleMesh empty;
  const std::string model = model_of({.mesh = empty});
  EXPECT_NE(model.find("<resources>\n</resources>\n<build>\n</build>"), std::string::npos);
}

TEST(ThreeMfFile, EqualMeshesAreEqualBytes) {
  EXPECT_EQ(written(MeshFormat::three_mf, {.mesh = kWritten}),
            written(MeshFormat::three_mf, {.mesh = kWritten}));
}

TEST(ThreeMfFile, ReportsWhatTheDiskSays) {
  testing::MemoryStorage storage;
  PendingFile file(storage, "mesh");
  storage.fail_at = storage.calls.size() + 1;
  try {
    write_mesh({.mesh = kWritten}, MeshFormat::three_mf, NoProgress(), file);
    ADD_FAILURE() << "written";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::io);
  }
}

}  // namespace
}  // namespace octavo
