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

/// What a map's database holds, by the names that checksums and errors have for it. All but the
/// leaves share RocksDB's default column family, told apart by the first letter of their keys: a
/// column family has its price, and there may be thousands of maps.
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

/// What the databases of all maps share.
struct SharedResources {
  explicit SharedResources(const StoreOptions& options, rocksdb::Env* environment = nullptr);

  std::shared_ptr<rocksdb::Cache> cache;
  std::shared_ptr<rocksdb::WriteBufferManager> write_buffers;
  rocksdb::Env* environment;  ///< The file system; outlives everything.
};

/// RocksDB as a map's store uses it: its options, its column families, and what a failed write
/// means.
///
/// Thread-safe.
class StateDatabase {
 public:
  enum class Mode {
    kCreate,     ///< There must be none.
    kReadWrite,  ///< There must be one.
    /// Likewise; writes nothing at all, so that it works on a full disk. What a power cut left of
    /// the last write is overlooked, as the other mode cuts it off.
    kReadOnly,
  };

  /// Opens the database in `folder`. Errors: `DataLoss` with reason `CHECKSUM` if it is damaged or
  /// missing; `Internal`.
  static absl::StatusOr<std::unique_ptr<StateDatabase>> Open(const std::filesystem::path& folder,
                                                             Mode mode,
                                                             const SharedResources& shared);
  ~StateDatabase();
  StateDatabase(const StateDatabase&) = delete;
  StateDatabase& operator=(const StateDatabase&) = delete;

  /// Reads every block of every table, and every value, and compares them with their checksums.
  /// Errors: `DataLoss` with reason `CHECKSUM` for the first that does not match.
  absl::Status Verify() const;

  /// Makes the database in `folder` one that opens, from the tables and the write-ahead logs that
  /// can be read; what they held is lost where they cannot. Errors: as `Open`.
  static absl::Status Repair(const std::filesystem::path& folder, const SharedResources& shared);

  /// Writes `batch` and syncs it, as one. The first failure is remembered and no write is tried
  /// after it: a sync that failed may have thrown the dirty pages away, so one that succeeds later
  /// proves nothing. Errors: `Unavailable` with reason `STORE_READ_ONLY`; for a database that was
  /// opened for reading alone `ResourceExhausted` with reason `DISK_LOW`.
  absl::Status Write(rocksdb::WriteBatch* batch);

  /// The value of `key`; `NotFound` if there is none.
  absl::StatusOr<std::string> Read(Family family,
                                   std::string_view key,
                                   const rocksdb::Snapshot* snapshot = nullptr) const;

  /// An iterator over `snapshot` (null: now) that ends before `*upper_bound`, which must outlive
  /// it.
  std::unique_ptr<rocksdb::Iterator> Scan(Family family,
                                          const rocksdb::Slice* upper_bound,
                                          const rocksdb::Snapshot* snapshot = nullptr) const;

  /// OK, or why nothing can be written.
  absl::Status health() const;

  rocksdb::DB& database() { return *database_; }

  rocksdb::ColumnFamilyHandle* handle(Family family) const {
    return family == Family::kLeaf ? leaf_handle_ : state_handle_;
  }

 private:
  class ErrorListener;

  /// What the listener, which RocksDB may hold for longer than we live, shares with us.
  struct Health {
    absl::Mutex mutex;
    absl::Status status ABSL_GUARDED_BY(mutex);
  };

  StateDatabase() = default;

  std::shared_ptr<Health> health_ = std::make_shared<Health>();
  std::unique_ptr<rocksdb::Env> environment_;  ///< Where it is not the shared one.
  std::unique_ptr<rocksdb::DB> database_;
  rocksdb::ColumnFamilyHandle* state_handle_ = nullptr;  ///< Owned by `database_`.
  rocksdb::ColumnFamilyHandle* leaf_handle_ = nullptr;   ///< Likewise.
};

/// A status of RocksDB in our words; `doing` completes "the store failed ...".
absl::Status FromRocksdb(const rocksdb::Status& status, std::string_view doing);

}  // namespace steadymap
