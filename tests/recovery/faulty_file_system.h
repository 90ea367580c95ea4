#pragma once

#include <atomic>
#include <memory>
#include <string>

#include <rocksdb/env.h>
#include <rocksdb/file_system.h>

namespace steadymap {

/// A file system with fault injection: it fails the syncs of RocksDB's files on request, or reports
/// a full disk.
class FaultyFileSystem final : public rocksdb::FileSystemWrapper {
 public:
  FaultyFileSystem();

  const char* Name() const override { return "FaultyFileSystem"; }

  rocksdb::IOStatus NewWritableFile(const std::string& name,
                                    const rocksdb::FileOptions& options,
                                    std::unique_ptr<rocksdb::FSWritableFile>* result,
                                    rocksdb::IODebugContext* debug) override;

  std::atomic<bool> fail_sync = false;  ///< Every sync fails.
  std::atomic<bool> disk_full = false;  ///< Every write fails for lack of space.
  std::atomic<int> syncs = 0;           ///< Number of requested syncs.
};

}  // namespace steadymap
