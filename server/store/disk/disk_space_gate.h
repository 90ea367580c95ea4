#pragma once

#include <atomic>
#include <memory>
#include <string>

#include <rocksdb/env.h>
#include <rocksdb/file_system.h>

namespace steadymap {

/// A file system for RocksDB in which nothing runs out of disk space: what finds none waits until
/// there is some. RocksDB itself takes a full disk for an error that it cannot go on after, and
/// Debian's build, which has its assertions on, sometimes ends the process.
///
/// Space is taken for bytes before they are written, so that no write stops halfway. Threads that
/// wait hold up nobody but the map whose files they write. Thread-safe.
class DiskSpaceGate final : public rocksdb::FileSystemWrapper {
 public:
  /// Over `target`, the file system that really writes.
  explicit DiskSpaceGate(const std::shared_ptr<rocksdb::FileSystem>& target);

  const char* Name() const override { return "DiskSpaceGate"; }

  /// Threads that wait for space.
  int waiting() const { return waiting_.load(); }

  /// Lets those who wait fail, now and from now on: the process is about to end.
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

  /// Runs `attempt` until it ends with something else than a full disk.
  template <typename Attempt>
  rocksdb::IOStatus Await(const Attempt& attempt);

  std::atomic<int> waiting_ = 0;
  std::atomic<bool> stopped_ = false;
};

}  // namespace steadymap
