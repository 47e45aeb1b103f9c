#include <memory>
#include <optional>

#include "octavo/file/storage/pending_file.h"
#include "octavo/io/export/export_target.h"
#include "octavo/io/export/gzip_writer.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

class FlatTarget final : public ExportTarget {
 public:
  FlatTarget(Storage& storage, const std::string& path, const ExportPlan& plan,
             const ByteString& header, bool gzipped)
      : overwrite_(plan.overwrite) {
    require_free(storage, path, overwrite_);
    file_ = std::make_unique<PendingFile>(storage, path);
    if (gzipped) gzip_.emplace(*file_);
    write_planes(header);
  }

  void write_planes(std::span<const std::uint8_t> planes) override {
    if (gzip_) {
      gzip_->append(planes);
    } else {
      file_->append(planes);
    }
  }

  std::vector<std::string> finish() override {
    if (gzip_) gzip_->finish();
    file_->seal();
    file_->publish(overwrite_);
    return {file_->path()};
  }

  std::uint64_t bytes() const override { return file_->size(); }

 private:
  bool overwrite_;
  std::unique_ptr<PendingFile> file_;
  std::optional<GzipWriter> gzip_;
};

/// "scan.mhd" -> "scan.raw"
std::string data_path_of(const std::string& header_path) {
  const std::size_t ending = has_ending(header_path, ".mhd") ? 4 : 0;
  return header_path.substr(0, header_path.size() - ending) + ".raw";
}

/// Both files are sealed before either takes its name.
class DetachedTarget final : public ExportTarget {
 public:
  DetachedTarget(Storage& storage, const std::string& path, const ExportPlan& plan)
      : storage_(storage), overwrite_(plan.overwrite) {
    const std::string data_path = data_path_of(path);
    settle_pair(storage, path, data_path);
    require_free(storage, path, overwrite_);
    require_free(storage, data_path, overwrite_);
    data_ = std::make_unique<PendingFile>(storage, data_path);
    header_ = std::make_unique<PendingFile>(storage, path);
    header_->append(meta_header(plan, base_name(data_path)));
  }

  void write_planes(std::span<const std::uint8_t> planes) override { data_->append(planes); }

  std::vector<std::string> finish() override {
    header_->seal();
    data_->seal();
    publish_pair(storage_, *header_, *data_, overwrite_);
    return {header_->path(), data_->path()};
  }

  std::uint64_t bytes() const override { return header_->size() + data_->size(); }

 private:
  Storage& storage_;
  bool overwrite_;
  std::unique_ptr<PendingFile> data_;
  std::unique_ptr<PendingFile> header_;
};

}  // namespace

std::unique_ptr<ExportTarget> make_flat_target(Storage& storage, const std::string& path,
                                               const ExportPlan& plan, const ByteString& header,
                                               bool gzipped) {
  return std::make_unique<FlatTarget>(storage, path, plan, header, gzipped);
}

std::unique_ptr<ExportTarget> make_detached_target(Storage& storage, const std::string& path,
                                                   const ExportPlan& plan) {
  return std::make_unique<DetachedTarget>(storage, path, plan);
}

}  // namespace octavo
