#include "server/store/disk/disk_space_gate.h"

#include <chrono>
#include <cstdint>
#include <thread>
#include <utility>

#include <spdlog/spdlog.h>

namespace steadymap {
namespace {

constexpr std::chrono::milliseconds kRetryInterval{200};

}  // namespace

/// A file that reserves disk space before each write.
class DiskSpaceGate::File final : public rocksdb::FSWritableFileOwnerWrapper {
 public:
  File(std::unique_ptr<rocksdb::FSWritableFile> file, DiskSpaceGate* gate)
      : FSWritableFileOwnerWrapper(std::move(file)), gate_(gate) {}

  rocksdb::IOStatus Append(const rocksdb::Slice& data,
                           const rocksdb::IOOptions& options,
                           rocksdb::IODebugContext* debug) override {
    if (rocksdb::IOStatus status = Reserve(data.size(), options, debug); !status.ok()) {
      return status;
    }
    return FSWritableFileOwnerWrapper::Append(data, options, debug);
  }

  rocksdb::IOStatus Append(const rocksdb::Slice& data,
                           const rocksdb::IOOptions& options,
                           const rocksdb::DataVerificationInfo& verification,
                           rocksdb::IODebugContext* debug) override {
    if (rocksdb::IOStatus status = Reserve(data.size(), options, debug); !status.ok()) {
      return status;
    }
    return FSWritableFileOwnerWrapper::Append(data, options, verification, debug);
  }

 private:
  rocksdb::IOStatus Reserve(std::size_t bytes,
                            const rocksdb::IOOptions& options,
                            rocksdb::IODebugContext* debug) {
    if (bytes == 0) return rocksdb::IOStatus::OK();
    const std::uint64_t end = GetFileSize(options, debug);
    const rocksdb::IOStatus status =
        gate_->Await([&] { return Allocate(end, bytes, options, debug); });
    // Reservation is optional: a file system that does not support it writes without one.
    return status.IsNoSpace() ? status : rocksdb::IOStatus::OK();
  }

  DiskSpaceGate* const gate_;
};

DiskSpaceGate::DiskSpaceGate(const std::shared_ptr<rocksdb::FileSystem>& target)
    : FileSystemWrapper(target) {}

template <typename Attempt>
rocksdb::IOStatus DiskSpaceGate::Await(const Attempt& attempt) {
  rocksdb::IOStatus status = attempt();
  if (!status.IsNoSpace()) return status;
  if (waiting_.fetch_add(1) == 0) {
    spdlog::error("the disk of the data folder is full; writes wait for free space");
  }
  while (status.IsNoSpace() && !stopped_) {
    std::this_thread::sleep_for(kRetryInterval);
    status = attempt();
  }
  if (waiting_.fetch_sub(1) == 1 && status.ok()) {
    spdlog::info("the disk of the data folder has free space again; writes continue");
  }
  return status;
}

rocksdb::IOStatus DiskSpaceGate::NewWritableFile(const std::string& name,
                                                 const rocksdb::FileOptions& options,
                                                 std::unique_ptr<rocksdb::FSWritableFile>* result,
                                                 rocksdb::IODebugContext* debug) {
  rocksdb::IOStatus status =
      Await([&] { return FileSystemWrapper::NewWritableFile(name, options, result, debug); });
  if (status.ok()) *result = std::make_unique<File>(std::move(*result), this);
  return status;
}

rocksdb::IOStatus DiskSpaceGate::ReopenWritableFile(
    const std::string& name,
    const rocksdb::FileOptions& options,
    std::unique_ptr<rocksdb::FSWritableFile>* result,
    rocksdb::IODebugContext* debug) {
  rocksdb::IOStatus status =
      Await([&] { return FileSystemWrapper::ReopenWritableFile(name, options, result, debug); });
  if (status.ok()) *result = std::make_unique<File>(std::move(*result), this);
  return status;
}

rocksdb::IOStatus DiskSpaceGate::ReuseWritableFile(const std::string& name,
                                                   const std::string& old_name,
                                                   const rocksdb::FileOptions& options,
                                                   std::unique_ptr<rocksdb::FSWritableFile>* result,
                                                   rocksdb::IODebugContext* debug) {
  rocksdb::IOStatus status = Await(
      [&] { return FileSystemWrapper::ReuseWritableFile(name, old_name, options, result, debug); });
  if (status.ok()) *result = std::make_unique<File>(std::move(*result), this);
  return status;
}

rocksdb::IOStatus DiskSpaceGate::RenameFile(const std::string& from,
                                            const std::string& to,
                                            const rocksdb::IOOptions& options,
                                            rocksdb::IODebugContext* debug) {
  return Await([&] { return FileSystemWrapper::RenameFile(from, to, options, debug); });
}

rocksdb::IOStatus DiskSpaceGate::CreateDirIfMissing(const std::string& name,
                                                    const rocksdb::IOOptions& options,
                                                    rocksdb::IODebugContext* debug) {
  return Await([&] { return FileSystemWrapper::CreateDirIfMissing(name, options, debug); });
}

}  // namespace steadymap
