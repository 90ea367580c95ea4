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
#include <rocksdb/db.h>

#include "server/folder_lock.h"
#include "server/store.h"

namespace steadymap {

/// The column families.
enum class Family : std::size_t {
  kLog,
  kDedup,
  kLeaf,
  kObject,
  kEvent,
  kFree,
  kRobot,
  kChange,
  kPose,
  kMeta
};

inline constexpr std::array<std::string_view, 10> kFamilyNames = {
    "log", "dedup", "leaf", "object", "event", "free", "robot", "change", "pose", "meta"};

/// Those whose keys start with a map: all but `meta`.
inline constexpr std::array kMapFamilies = {Family::kLog,
                                            Family::kDedup,
                                            Family::kLeaf,
                                            Family::kObject,
                                            Family::kEvent,
                                            Family::kFree,
                                            Family::kRobot,
                                            Family::kChange,
                                            Family::kPose};

constexpr std::string_view NameOf(Family family) {
  return kFamilyNames[static_cast<std::size_t>(family)];
}

/// RocksDB as the store uses it: its options, its column families, and what a failed write means.
///
/// Thread-safe.
class StoreDatabase {
 public:
  /// Opens or creates the database in `folder`. `environment` stands for the file system; null: the
  /// real one. Errors: as `Store::Open`.
  static absl::StatusOr<std::unique_ptr<StoreDatabase>> Open(const std::filesystem::path& folder,
                                                             const StoreOptions& options,
                                                             rocksdb::Env* environment);
  ~StoreDatabase();
  StoreDatabase(const StoreDatabase&) = delete;
  StoreDatabase& operator=(const StoreDatabase&) = delete;

  /// Writes `batch` and syncs it, as one. The first failure is remembered and no write is tried
  /// after it: a sync that failed may have thrown the dirty pages away, so one that succeeds later
  /// proves nothing. Errors: `Unavailable` with reason `STORE_READ_ONLY`.
  absl::Status Write(rocksdb::WriteBatch* batch);

  /// The value of `key`; `NotFound` if there is none, `DataLoss` if it is damaged.
  absl::StatusOr<std::string> Read(Family family,
                                   std::string_view key,
                                   const rocksdb::Snapshot* snapshot = nullptr) const;

  /// An iterator over `snapshot` (null: now) that ends before `*upper_bound`, which must outlive
  /// it.
  std::unique_ptr<rocksdb::Iterator> Scan(Family family,
                                          const rocksdb::Slice* upper_bound,
                                          const rocksdb::Snapshot* snapshot = nullptr) const;

  /// Gives the space of deleted keys back to the disk: flushes now, which takes up to some 100 ms,
  /// and compacts in the background.
  void Reclaim(Family family);

  /// Free bytes for the daemon's user on the folder's disk. Errors: `Internal` if nobody can tell.
  absl::StatusOr<std::uint64_t> FreeDiskBytes() const;

  /// OK, or the error that made the database read-only.
  absl::Status health() const;

  rocksdb::DB& database() { return *database_; }

  rocksdb::ColumnFamilyHandle* handle(Family family) const {
    return handles_[static_cast<std::size_t>(family)];
  }

 private:
  class ErrorListener;

  /// What the listener, which RocksDB may hold for longer than we live, shares with us.
  struct Health {
    absl::Mutex mutex;
    absl::Status status ABSL_GUARDED_BY(mutex);
  };

  StoreDatabase(FolderLock lock, std::filesystem::path folder);

  FolderLock lock_;
  std::filesystem::path folder_;
  std::shared_ptr<Health> health_ = std::make_shared<Health>();
  std::unique_ptr<rocksdb::DB> database_;
  std::vector<rocksdb::ColumnFamilyHandle*> handles_;  ///< By `Family`; owned by `database_`.
  rocksdb::ColumnFamilyHandle* default_handle_ = nullptr;
};

/// A status of RocksDB in our words; `doing` completes "the store failed ...".
absl::Status FromRocksdb(const rocksdb::Status& status, std::string_view doing);

}  // namespace steadymap
