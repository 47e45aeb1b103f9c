#include "octavo/mesh/formats/zip_archive.h"

#include <minizip/zip.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "octavo/core/error.h"

namespace octavo {

/// What minizip calls. Exceptions wait in the archive, as C code cannot pass them on.
struct ZipCalls {
  static ZipArchive& archive(void* opaque) { return *static_cast<ZipArchive*>(opaque); }

  static void* open(void* opaque, const void*, int) { return opaque; }

  static uLong read(void*, void*, void*, uLong) { return 0; }

  static uLong write(void* opaque, void*, const void* data, uLong size) noexcept {
    ZipArchive& zip = archive(opaque);
    if (zip.failure_) return 0;
    try {
      // Sizes are written into the head of an entry once they are known.
      const ByteSpan bytes(static_cast<const std::uint8_t*>(data), size);
      const std::size_t known =
          std::min<std::uint64_t>(zip.file_.size() - zip.position_, bytes.size());
      if (known > 0) zip.file_.file().write(zip.position_, bytes.first(known));
      if (known < bytes.size()) zip.file_.append(bytes.subspan(known));
      zip.position_ += bytes.size();
      return size;
    } catch (...) {
      zip.failure_ = std::current_exception();
      return 0;
    }
  }

  static ZPOS64_T tell(void* opaque, void*) { return archive(opaque).position_; }

  static long seek(void* opaque, void*, ZPOS64_T offset, int origin) {
    ZipArchive& zip = archive(opaque);
    const std::uint64_t size = zip.file_.size();
    std::uint64_t from = 0;
    if (origin == ZLIB_FILEFUNC_SEEK_CUR) from = zip.position_;
    if (origin == ZLIB_FILEFUNC_SEEK_END) from = size;
    if (from + offset > size) return -1;
    zip.position_ = from + offset;
    return 0;
  }

  static int close(void*, void*) { return 0; }

  static int error(void* opaque, void*) { return archive(opaque).failure_ ? 1 : 0; }
};

ZipArchive::ZipArchive(PendingFile& file) : file_(file) {
  zlib_filefunc64_def calls{};
  calls.zopen64_file = ZipCalls::open;
  calls.zread_file = ZipCalls::read;
  calls.zwrite_file = ZipCalls::write;
  calls.ztell64_file = ZipCalls::tell;
  calls.zseek64_file = ZipCalls::seek;
  calls.zclose_file = ZipCalls::close;
  calls.zerror_file = ZipCalls::error;
  calls.opaque = this;
  zip_ = zipOpen2_64(file.path().c_str(), APPEND_STATUS_CREATE, nullptr, &calls);
  require(zip_ == nullptr ? ZIP_INTERNALERROR : ZIP_OK);
}

ZipArchive::~ZipArchive() {
  if (zip_ == nullptr) return;
  // Only to let go of memory: the file is given up.
  if (!failure_) failure_ = std::make_exception_ptr(Error(ErrorKind::internal, "given up"));
  zipClose(zip_, nullptr);
}

void ZipArchive::begin(const std::string& name, bool is_large) {
  constexpr uLong kFirstOfJanuary1980 = 1u << 5 | 1u;
  constexpr uLong kMadeBy = 0;
  constexpr uLong kNoFlags = 0;
  end_entry();
  zip_fileinfo info{};
  info.dosDate = kFirstOfJanuary1980 << 16;
  require(zipOpenNewFileInZip4_64(zip_, name.c_str(), &info, nullptr, 0, nullptr, 0, nullptr,
                                  Z_DEFLATED, Z_BEST_SPEED, 0, -MAX_WBITS, DEF_MEM_LEVEL,
                                  Z_DEFAULT_STRATEGY, nullptr, 0, kMadeBy, kNoFlags,
                                  is_large ? 1 : 0));
  is_in_entry_ = true;
}

void ZipArchive::append(ByteSpan bytes) {
  while (!bytes.empty()) {
    const std::size_t size =
        std::min<std::size_t>(bytes.size(), std::numeric_limits<std::int32_t>::max());
    require(zipWriteInFileInZip(zip_, bytes.data(), static_cast<unsigned>(size)));
    bytes = bytes.subspan(size);
  }
}

void ZipArchive::finish() {
  end_entry();
  require(zipClose(std::exchange(zip_, nullptr), nullptr));
}

void ZipArchive::end_entry() {
  if (!std::exchange(is_in_entry_, false)) return;
  require(zipCloseFileInZip(zip_));
}

void ZipArchive::require(int status) {
  if (failure_) std::rethrow_exception(failure_);
  if (status == ZIP_OK) return;
  throw Error(ErrorKind::internal, "minizip gave up with " + std::to_string(status), file_.path());
}

}  // namespace octavo
