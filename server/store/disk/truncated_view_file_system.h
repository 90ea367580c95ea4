#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <rocksdb/file_system.h>

namespace steadymap {

/// A file system in which one file seems to end earlier than it does, for readers from its start to
/// its end. It lets RocksDB read a log without what a power cut left of its last write, where the
/// log itself must not be changed. Thread-safe.
class TruncatedViewFileSystem final : public rocksdb::FileSystemWrapper {
 public:
  /// Over `target`. `file` is the name without its folder: a database has no two of one name.
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
