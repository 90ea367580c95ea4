#pragma once

#include <atomic>
#include <memory>
#include <string>

#include <rocksdb/env.h>
#include <rocksdb/file_system.h>

namespace steadymap {

/// A file system for RocksDB in which no operation fails because the disk is full: the operation
/// waits for free space instead. RocksDB itself treats a full disk as a fatal error, and Debian's
/// build, which has assertions enabled, sometimes aborts the process.
///
/// Reserves disk space before each write, so that no write stops halfway. A waiting thread delays
/// only operations on the map whose files it writes. Thread-safe.
class DiskSpaceGate final : public rocksdb::FileSystemWrapper {
 public:
  /// Wraps `target`, the file system that performs the writes.
  explicit DiskSpaceGate(const std::shared_ptr<rocksdb::FileSystem>& target);

  const char* Name() const override { return "DiskSpaceGate"; }

  /// Returns the number of threads that wait for free space.
  int waiting() const { return waiting_.load(); }

  /// Makes waiting operations fail, now and later. Called before the process ends.
  void Stop() { stopped_ = true; }

  rocksdb::IOStatus NewWritableFile(const std::string& name,
                                    const rocksdb::FileOptions& options,
                                    std::unique_ptr<rocksdb::FSWritableFile>* result,
                                    rocksdb::IODebugContext* debug) override;
  rocksdb::IOStatus ReopenWritableFile(const std::string& name,
                                       const rocksdb::FileOptions& options,
                                       std::unique_ptr<rocksdb::FSWritableFile>* result,
                                       rocksdb::IODebugContext* debug) override;
  rocksdb::IOStatus ReuseWritableFile(const std::string& name,
                                      const std::string& old_name,
                                      const rocksdb::FileOptions& options,
                                      std::unique_ptr<rocksdb::FSWritableFile>* result,
                                      rocksdb::IODebugContext* debug) override;
  rocksdb::IOStatus RenameFile(const std::string& from,
                               const std::string& to,
                               const rocksdb::IOOptions& options,
                               rocksdb::IODebugContext* debug) override;
  rocksdb::IOStatus CreateDirIfMissing(const std::string& name,
                                       const rocksdb::IOOptions& options,
                                       rocksdb::IODebugContext* debug) override;

 private:
  class File;

  /// Repeats `attempt` while it fails because the disk is full.
  template <typename Attempt>
  rocksdb::IOStatus Await(const Attempt& attempt);

  std::atomic<int> waiting_ = 0;
  std::atomic<bool> stopped_ = false;
};

}  // namespace steadymap
