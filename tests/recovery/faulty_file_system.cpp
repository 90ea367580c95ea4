#include "tests/recovery/faulty_file_system.h"

#include <utility>

namespace steadymap {
namespace {

class FaultyFile final : public rocksdb::FSWritableFileOwnerWrapper {
 public:
  FaultyFile(std::unique_ptr<rocksdb::FSWritableFile> file, FaultyFileSystem* faults)
      : FSWritableFileOwnerWrapper(std::move(file)), faults_(faults) {}

  rocksdb::IOStatus Allocate(std::uint64_t offset,
                             std::uint64_t length,
                             const rocksdb::IOOptions& options,
                             rocksdb::IODebugContext* debug) override {
    if (faults_->disk_full) return rocksdb::IOStatus::NoSpace("the test filled the disk");
    return FSWritableFileOwnerWrapper::Allocate(offset, length, options, debug);
  }

  rocksdb::IOStatus Sync(const rocksdb::IOOptions& options,
                         rocksdb::IODebugContext* debug) override {
    ++faults_->syncs;
    if (faults_->fail_sync) return rocksdb::IOStatus::IOError("the test failed the sync");
    return FSWritableFileOwnerWrapper::Sync(options, debug);
  }

  rocksdb::IOStatus Fsync(const rocksdb::IOOptions& options,
                          rocksdb::IODebugContext* debug) override {
    return Sync(options, debug);
  }

 private:
  FaultyFileSystem* faults_;
};

}  // namespace

FaultyFileSystem::FaultyFileSystem() : FileSystemWrapper(rocksdb::FileSystem::Default()) {}

rocksdb::IOStatus FaultyFileSystem::NewWritableFile(
    const std::string& name,
    const rocksdb::FileOptions& options,
    std::unique_ptr<rocksdb::FSWritableFile>* result,
    rocksdb::IODebugContext* debug) {
  rocksdb::IOStatus status = FileSystemWrapper::NewWritableFile(name, options, result, debug);
  if (status.ok()) {
    *result = std::make_unique<FaultyFile>(std::move(*result), this);
  }
  return status;
}

}  // namespace steadymap
