#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>
#include <rocksdb/cache.h>
#include <rocksdb/db.h>
#include <rocksdb/write_buffer_manager.h>

#include "server/store/model/store.h"

namespace steadymap {

/// The families of records in a map's database, named as in checksums and errors. All families
/// except the leaves share RocksDB's default column family and are distinguished by the first
/// letter of their keys: each column family costs memory, and a store may have thousands of maps.
enum class Family : std::size_t {
  kLeaf,
  kSession,
  kObject,
  kEvent,
  kFree,
  kRobot,
  kChange,
  kPose,
  kMeta
};

inline constexpr std::array<std::string_view, 9> kFamilyNames = {
    "leaf", "session", "object", "event", "free", "robot", "change", "pose", "meta"};

constexpr std::string_view NameOf(Family family) {
  return kFamilyNames[static_cast<std::size_t>(family)];
}

/// The resources shared by the databases of all maps.
struct SharedResources {
  explicit SharedResources(const StoreOptions& options, rocksdb::Env* environment = nullptr);

  std::shared_ptr<rocksdb::Cache> cache;
  std::shared_ptr<rocksdb::WriteBufferManager> write_buffers;
  rocksdb::Env* environment;  ///< The file system; outlives all databases.
};

/// A RocksDB database of one map, with its options, its column families and its handling of failed
/// writes.
class StateDatabase {
 public:
  enum class Mode {
    kCreate,     ///< The database must not exist.
    kReadWrite,  ///< The database must exist.
    /// The database must exist. Nothing is written, so this mode works on a full disk. Ignores a
    /// torn write at the end of the write-ahead log, which `kReadWrite` truncates.
    kReadOnly,
  };

  /// Opens the database in `folder`. Errors: `DataLoss` with reason `CHECKSUM` if it is damaged or
  /// missing; `Internal` for any other failure.
  static absl::StatusOr<std::unique_ptr<StateDatabase>> Open(const std::filesystem::path& folder,
                                                             Mode mode,
                                                             const SharedResources& shared);
  ~StateDatabase();
  StateDatabase(const StateDatabase&) = delete;
  StateDatabase& operator=(const StateDatabase&) = delete;

  /// Reads every block of every table and every value, and verifies their checksums. Errors:
  /// `DataLoss` with reason `CHECKSUM` for the first mismatch.
  absl::Status Verify() const;

  /// Repairs the database in `folder` from the readable tables and write-ahead logs, so that it can
  /// be opened. The content of unreadable ones is lost. Errors: as `Open`.
  static absl::Status Repair(const std::filesystem::path& folder, const SharedResources& shared);

  /// Writes `batch` atomically and syncs it. Remembers the first failure and attempts no write
  /// after it: a failed sync may have discarded the dirty pages, so a later successful sync proves
  /// nothing. Errors: `Unavailable` with reason `STORE_READ_ONLY`; `ResourceExhausted` with reason
  /// `DISK_LOW` for a database that was opened read-only.
  absl::Status Write(rocksdb::WriteBatch* batch);

  /// Returns the value of `key`; `NotFound` if the key does not exist.
  absl::StatusOr<std::string> Read(Family family,
                                   std::string_view key,
                                   const rocksdb::Snapshot* snapshot = nullptr) const;

  /// Returns an iterator over `snapshot` (null: the newest state) that ends before `*upper_bound`,
  /// which must outlive the iterator.
  std::unique_ptr<rocksdb::Iterator> Scan(Family family,
                                          const rocksdb::Slice* upper_bound,
                                          const rocksdb::Snapshot* snapshot = nullptr) const;

  /// Returns OK, or the error that prevents writes.
  absl::Status health() const;

  rocksdb::DB& database() { return *database_; }

  rocksdb::ColumnFamilyHandle* handle(Family family) const {
    return family == Family::kLeaf ? leaf_handle_ : state_handle_;
  }

 private:
  class ErrorListener;

  /// The state shared with the listener, which RocksDB may keep longer than this object exists.
  struct Health {
    absl::Mutex mutex;
    absl::Status status ABSL_GUARDED_BY(mutex);
  };

  StateDatabase() = default;

  std::shared_ptr<Health> health_ = std::make_shared<Health>();
  std::unique_ptr<rocksdb::Env> environment_;  ///< Set if it differs from the shared one.
  std::unique_ptr<rocksdb::DB> database_;
  rocksdb::ColumnFamilyHandle* state_handle_ = nullptr;  ///< Owned by `database_`.
  rocksdb::ColumnFamilyHandle* leaf_handle_ = nullptr;   ///< Owned by `database_`.
};

/// Converts a status of RocksDB; `doing` completes "the store failed ...".
absl::Status FromRocksdb(const rocksdb::Status& status, std::string_view doing);

}  // namespace steadymap
