#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <rocksdb/file_system.h>

namespace steadymap {

/// A file system in which one file appears shorter than it is, for sequential readers. With it,
/// RocksDB reads a write-ahead log without the torn last write that a power cut left, where the log
/// itself must not be changed. Thread-safe.
class TruncatedViewFileSystem final : public rocksdb::FileSystemWrapper {
 public:
  /// Wraps `target`. `file` is the file name without its folder; file names are unique within a
  /// database.
  TruncatedViewFileSystem(const std::shared_ptr<rocksdb::FileSystem>& target,
                          std::string file,
                          std::uint64_t size);

  const char* Name() const override { return "TruncatedViewFileSystem"; }

  rocksdb::IOStatus NewSequentialFile(const std::string& name,
                                      const rocksdb::FileOptions& options,
                                      std::unique_ptr<rocksdb::FSSequentialFile>* result,
                                      rocksdb::IODebugContext* debug) override;
  rocksdb::IOStatus GetFileSize(const std::string& name,
                                const rocksdb::IOOptions& options,
                                std::uint64_t* size,
                                rocksdb::IODebugContext* debug) override;

 private:
  class File;

  bool IsShortened(const std::string& name) const;

  const std::string file_;
  const std::uint64_t size_;
};

}  // namespace steadymap
