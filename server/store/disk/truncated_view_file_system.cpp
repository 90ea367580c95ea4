#include "server/store/disk/truncated_view_file_system.h"

#include <algorithm>
#include <filesystem>
#include <utility>

namespace steadymap {

/// A file that appears to end after `size` bytes.
class TruncatedViewFileSystem::File final : public rocksdb::FSSequentialFileOwnerWrapper {
 public:
  File(std::unique_ptr<rocksdb::FSSequentialFile> target, std::uint64_t size)
      : FSSequentialFileOwnerWrapper(std::move(target)), left_(size) {}

  rocksdb::IOStatus Read(std::size_t count,
                         const rocksdb::IOOptions& options,
                         rocksdb::Slice* result,
                         char* scratch,
                         rocksdb::IODebugContext* debug) override {
    const std::size_t wanted = std::min<std::uint64_t>(count, left_);
    rocksdb::IOStatus status =
        FSSequentialFileOwnerWrapper::Read(wanted, options, result, scratch, debug);
    if (status.ok()) left_ -= result->size();
    return status;
  }

  rocksdb::IOStatus Skip(std::uint64_t count) override {
    const std::uint64_t skipped = std::min(count, left_);
    left_ -= skipped;
    return FSSequentialFileOwnerWrapper::Skip(skipped);
  }

 private:
  std::uint64_t left_;  ///< Bytes that remain up to the apparent end.
};

TruncatedViewFileSystem::TruncatedViewFileSystem(const std::shared_ptr<rocksdb::FileSystem>& target,
                                                 std::string file,
                                                 std::uint64_t size)
    : FileSystemWrapper(target), file_(std::move(file)), size_(size) {}

rocksdb::IOStatus TruncatedViewFileSystem::NewSequentialFile(
    const std::string& name,
    const rocksdb::FileOptions& options,
    std::unique_ptr<rocksdb::FSSequentialFile>* result,
    rocksdb::IODebugContext* debug) {
  rocksdb::IOStatus status = FileSystemWrapper::NewSequentialFile(name, options, result, debug);
  if (status.ok() && IsShortened(name)) *result = std::make_unique<File>(std::move(*result), size_);
  return status;
}

rocksdb::IOStatus TruncatedViewFileSystem::GetFileSize(const std::string& name,
                                                       const rocksdb::IOOptions& options,
                                                       std::uint64_t* size,
                                                       rocksdb::IODebugContext* debug) {
  rocksdb::IOStatus status = FileSystemWrapper::GetFileSize(name, options, size, debug);
  if (status.ok() && IsShortened(name)) *size = std::min(*size, size_);
  return status;
}

bool TruncatedViewFileSystem::IsShortened(const std::string& name) const {
  return std::filesystem::path(name).filename() == file_;
}

}  // namespace steadymap
