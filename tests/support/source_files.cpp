#include "support/source_files.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace octavo::testing {

namespace fs = std::filesystem;

TempFolder::TempFolder() {
  static std::atomic<int> count = 0;
  path_ = (fs::temp_directory_path() /
           ("octavo-io-" + std::to_string(::getpid()) + "-" + std::to_string(count++)))
              .string();
  fs::create_directories(path_);
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::string TempFolder::file(const std::string& name) const {
  const fs::path path = fs::path(path_) / name;
  fs::create_directories(path.parent_path());
  return path.string();
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

void write_file(const std::string& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  ASSERT_TRUE(file.flush()) << path;
}

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// window_bits  as zlib counts: 15; and 16 for a head of gzip, or negative for none
static std::string deflated(const std::string& bytes, int window_bits) {
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string out(deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  std::string in = bytes;
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::string gzip(const std::string& bytes) { return deflated(bytes, 15 + 16); }
std::string zlib_stream(const std::string& bytes) { return deflated(bytes, 15); }
std::string bare_deflate_stream(const std::string& bytes) { return deflated(bytes, -15); }

void write_parts(const TempFolder& folder, std::size_t count,
                 const std::function<std::string(const std::string&)>& file_of) {
  const std::string all = bytes_of(kStoredValues);
  const std::size_t part = all.size() / count;
  for (std::size_t i = 0; i < count; ++i) {
    write_file(folder.file("p" + std::to_string(i + 1) + ".raw"),
               file_of(all.substr(i * part, part)));
  }
}

std::string uneven_bytes(std::size_t count) {
  std::string bytes;
  std::uint32_t state = 7;
  for (std::size_t i = 0; i < count; ++i) {
    state = state * 1664525 + 1013904223;
    bytes += static_cast<char>(state >> 24);
  }
  return bytes;
}

std::string counted(std::size_t bytes, int start) {
  std::string text;
  for (std::size_t i = 0; i < bytes; ++i)
    text += static_cast<char>((start + static_cast<int>(i) * 7) % 251);
  return text;
}

std::string voxels_of(PlaneSource& source) {
  const VolumeDescription& d = source.description();
  const auto plane_bytes = static_cast<std::size_t>(d.size.x * d.size.y * bytes_per_voxel(d.type));
  std::string all(plane_bytes * static_cast<std::size_t>(d.size.z), '\0');
  for (std::size_t z = 0; z < static_cast<std::size_t>(d.size.z); ++z) {
    source.read_plane(std::as_writable_bytes(std::span(all.data() + z * plane_bytes, plane_bytes)));
  }
  return all;
}

Geometry geometry_of(const std::string& path, const SourceOptions& options) {
  return open_source({path}, options)->description().geometry;
}

Point3 spacing_of(const std::string& path) {
  return open_source({path}, {})->description().geometry.spacing_mm;
}

SourceOptions with_spacing(double x, double y, double z) {
  SourceOptions options;
  options.spacing_mm = Point3{x, y, z};
  return options;
}

std::string first_warning(const PlaneSource& source) {
  return source.warnings().empty() ? "" : with_hints(source.warnings().front());
}

Error error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no error was thrown";
  return Error(ErrorKind::internal, "no error was thrown");
}

Error source_error(const std::vector<std::string>& paths, const SourceOptions& options) {
  return error_of([&] { voxels_of(*open_source(paths, options)); });
}

void expect_rejected(const std::string& path, const std::vector<std::string>& words,
                     const SourceOptions& options) {
  const Error error = source_error({path}, options);
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
  for (const std::string& word : words) {
    EXPECT_TRUE(contains(error, word)) << with_hints(error) << "\nlacks " << word;
  }
}

void expect_every_truncation_rejected(const std::string& path, const std::string& whole) {
  for (std::size_t length = 0; length < whole.size(); ++length) {
    write_file(path, whole.substr(0, length));
    EXPECT_EQ(source_error({path}).kind(), ErrorKind::source_rejected) << path << " " << length;
  }
}

void write_meta(const std::string& path, const std::string& lines) {
  write_file(path, "NDims = 3\nDimSize = 4 3 2\nElementSpacing = 1 1 2\nElementType = MET_UCHAR\n" +
                       lines + "\nElementDataFile = LOCAL\n" + std::string(24, '\1'));
}

void write_nrrd(const std::string& path, const std::string& lines) {
  write_file(path, "NRRD0005\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n" + lines +
                       "\n\n" + std::string(24, '\1'));
}

std::string nifti_header(const NiftiSample& s) {
  std::string h(352, '\0');
  const auto put = [&](std::size_t at, const std::string& bytes) {
    h.replace(at, bytes.size(), bytes);
  };
  const auto put16 = [&](std::size_t at, std::int16_t v) {
    put(at, bytes_of<std::int16_t>({v}, s.big_endian));
  };
  const auto put_float = [&](std::size_t at, float v) {
    put(at, bytes_of<float>({v}, s.big_endian));
  };
  put(0, bytes_of<std::int32_t>({348}, s.big_endian));
  put16(40, static_cast<std::int16_t>(s.size.size()));
  for (std::size_t axis = 0; axis < s.size.size(); ++axis) {
    put16(42 + axis * 2, s.size[axis]);
    put_float(80 + axis * 4, 1);
  }
  put16(68, s.intent);
  put16(70, s.datatype);
  put16(72, s.bits);
  put_float(108, 352);
  put_float(112, s.slope);
  put_float(116, s.intercept);
  h[123] = 2;
  put16(254, s.sform);
  for (std::size_t i = 0; i < 12; ++i) put_float(280 + i * 4, s.srow[i]);
  put(344, std::string("n+1\0", 4));
  return h;
}

}  // namespace octavo::testing
