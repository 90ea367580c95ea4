#include "server/store/database/state_database.h"

#include <utility>

#include <absl/strings/str_cat.h>
#include <rocksdb/filter_policy.h>
#include <rocksdb/listener.h>
#include <rocksdb/table.h>
#include <rocksdb/write_batch.h>

#include "core/types/error.h"
#include "server/store/database/store_keys.h"
#include "server/store/database/store_records.h"
#include "server/store/disk/truncated_view_file_system.h"
#include "server/store/disk/wal_repair.h"

namespace steadymap {
namespace {

rocksdb::Slice ToSlice(std::string_view bytes) { return {bytes.data(), bytes.size()}; }

absl::Status ReadOnly(const std::string& cause) {
  return MakeError(absl::StatusCode::kUnavailable,
                   reason::kStoreReadOnly,
                   "the map is read-only until it is reopened: " + cause);
}

// Unit of memory allocation of a memtable. Small, because most maps are idle.
constexpr std::size_t kArenaBlockBytes = std::size_t{64} << 10;

// Approximate upper bound of the write-ahead log of a map that a restart replays.
constexpr std::uint64_t kMaxWalBytes = std::uint64_t{16} << 20;

constexpr std::string_view kLeafColumnFamily = "leaf";

rocksdb::DBOptions DatabaseOptions(const SharedResources& shared) {
  rocksdb::DBOptions result;
  result.env = shared.environment;
  // This is the only recovery mode that is safe for acknowledged commits. A torn end is a write
  // that was in progress at a power cut: it was never acknowledged, so it may be dropped. A bad
  // record before the end was synced and acknowledged; point-in-time recovery (RocksDB's default)
  // would silently drop it and everything after it. This mode refuses to open the database instead,
  // and the store reports DATA_LOSS. It would also refuse some torn ends; `CutTornLog` truncates
  // those beforehand.
  result.wal_recovery_mode = rocksdb::WALRecoveryMode::kTolerateCorruptedTailRecords;
  // Detects a write-ahead log that is missing or was truncated.
  result.track_and_verify_wals_in_manifest = true;
  result.paranoid_checks = true;
  // A failed write is never retried, so RocksDB must not retry in the background either.
  result.max_bgerror_resume_count = 0;
  result.write_buffer_manager = shared.write_buffers;
  // Otherwise a rarely written column family would keep old write-ahead logs without limit, and a
  // restart replays their content.
  result.max_total_wal_size = kMaxWalBytes;
  result.max_open_files = 64;
  result.max_background_jobs = 2;
  result.info_log_level = rocksdb::InfoLogLevel::WARN_LEVEL;
  result.max_log_file_size = std::size_t{1} << 20;
  result.keep_log_file_num = 2;
  result.stats_dump_period_sec = 0;
  result.stats_persist_period_sec = 0;
  return result;
}

rocksdb::ColumnFamilyOptions FamilyOptions(const SharedResources& shared) {
  rocksdb::ColumnFamilyOptions result;
  rocksdb::BlockBasedTableOptions table;
  table.block_cache = shared.cache;
  table.cache_index_and_filter_blocks = true;
  table.format_version = 5;
  result.table_factory.reset(rocksdb::NewBlockBasedTableFactory(table));
  result.write_buffer_size = shared.write_buffers->buffer_size() / 4;
  result.arena_block_size = kArenaBlockBytes;
  result.compression = rocksdb::kLZ4Compression;
  return result;
}

std::vector<rocksdb::ColumnFamilyDescriptor> Families(const SharedResources& shared) {
  rocksdb::ColumnFamilyOptions leaf = FamilyOptions(shared);
  leaf.compression = rocksdb::kNoCompression;  // the leaf codec compresses already
  return {{rocksdb::kDefaultColumnFamilyName, FamilyOptions(shared)},
          {std::string(kLeafColumnFamily), leaf}};
}

}  // namespace

SharedResources::SharedResources(const StoreOptions& options, rocksdb::Env* env)
    : cache(rocksdb::NewLRUCache(options.block_cache_bytes)),
      write_buffers(std::make_shared<rocksdb::WriteBufferManager>(options.write_buffer_bytes)),
      environment(env == nullptr ? rocksdb::Env::Default() : env) {}

absl::Status FromRocksdb(const rocksdb::Status& status, std::string_view doing) {
  if (status.ok()) return absl::OkStatus();
  const std::string message = absl::StrCat(
      "the store failed ", absl::string_view(doing.data(), doing.size()), ": ", status.ToString());
  if (status.IsNotFound()) return absl::NotFoundError(message);
  if (status.IsCorruption()) {
    return MakeError(absl::StatusCode::kDataLoss, reason::kChecksum, message);
  }
  return MakeError(absl::StatusCode::kInternal, reason::kInternal, message);
}

/// Records errors that occur in RocksDB's background threads.
class StateDatabase::ErrorListener final : public rocksdb::EventListener {
 public:
  explicit ErrorListener(std::shared_ptr<Health> health) : health_(std::move(health)) {}

  void OnBackgroundError(rocksdb::BackgroundErrorReason /*reason*/,
                         rocksdb::Status* error) override {
    const absl::MutexLock lock(&health_->mutex);
    if (health_->status.ok()) health_->status = ReadOnly(error->ToString());
  }

 private:
  std::shared_ptr<Health> health_;
};

absl::StatusOr<std::unique_ptr<StateDatabase>> StateDatabase::Open(
    const std::filesystem::path& folder, Mode mode, const SharedResources& shared) {
  if (mode == Mode::kReadWrite) {
    if (absl::Status status = CutTornLog(folder); !status.ok()) return status;
  }
  std::unique_ptr<StateDatabase> result(new StateDatabase());
  rocksdb::DBOptions options = DatabaseOptions(shared);
  if (mode == Mode::kReadOnly) {
    const absl::StatusOr<std::optional<TornLog>> torn = FindTornLog(folder);
    if (!torn.ok()) return torn.status();
    if (*torn) {
      result->environment_ = rocksdb::NewCompositeEnv(
          std::make_shared<TruncatedViewFileSystem>(shared.environment->GetFileSystem(),
                                                    (*torn)->file.filename().string(),
                                                    (*torn)->whole_end));
      options.env = result->environment_.get();
    }
  }
  options.create_if_missing = mode == Mode::kCreate;
  options.create_missing_column_families = mode == Mode::kCreate;
  options.error_if_exists = mode == Mode::kCreate;
  options.listeners.push_back(std::make_shared<ErrorListener>(result->health_));
  rocksdb::DB* database = nullptr;
  std::vector<rocksdb::ColumnFamilyHandle*> handles;
  const std::vector<rocksdb::ColumnFamilyDescriptor> families = Families(shared);
  rocksdb::Status status;
  if (mode == Mode::kReadOnly) {
    status = rocksdb::DB::OpenForReadOnly(options, folder.string(), families, &handles, &database);
    const absl::MutexLock lock(&result->health_->mutex);
    result->health_->status = MakeError(absl::StatusCode::kResourceExhausted,
                                        reason::kDiskLow,
                                        "the map is open read-only until the disk has free space");
  } else {
    status = rocksdb::DB::Open(options, folder.string(), families, &handles, &database);
  }
  // RocksDB reports missing files of a database as an invalid argument.
  if (status.IsInvalidArgument() || status.IsPathNotFound() || status.IsNotFound()) {
    return MakeError(absl::StatusCode::kDataLoss,
                     reason::kChecksum,
                     absl::StrCat("the database in ",
                                  folder.string(),
                                  " is missing or lacks files: ",
                                  status.ToString()));
  }
  if (!status.ok()) return FromRocksdb(status, "opening " + folder.string());
  result->database_.reset(database);
  result->state_handle_ = handles[0];
  result->leaf_handle_ = handles[1];
  return result;
}

StateDatabase::~StateDatabase() {
  if (database_ == nullptr) return;
  // A handle that cannot be destroyed is only leaked, and no caller is left to receive the error.
  database_->DestroyColumnFamilyHandle(leaf_handle_).PermitUncheckedError();
  database_->DestroyColumnFamilyHandle(state_handle_).PermitUncheckedError();
  database_->Close().PermitUncheckedError();
}

absl::Status StateDatabase::Write(rocksdb::WriteBatch* batch) {
  if (absl::Status status = health(); !status.ok()) return status;
  rocksdb::WriteOptions options;
  options.sync = true;
  const rocksdb::Status status = database_->Write(options, batch);
  if (status.ok()) return absl::OkStatus();
  const absl::MutexLock lock(&health_->mutex);
  if (health_->status.ok()) health_->status = ReadOnly(status.ToString());
  return health_->status;
}

absl::StatusOr<std::string> StateDatabase::Read(Family family,
                                                std::string_view key,
                                                const rocksdb::Snapshot* snapshot) const {
  rocksdb::ReadOptions options;
  options.snapshot = snapshot;
  std::string value;
  const rocksdb::Status status = database_->Get(options, handle(family), ToSlice(key), &value);
  if (status.IsNotFound()) {
    return absl::NotFoundError(absl::StrCat("the store has no key ", KeyAsHex(key)));
  }
  if (!status.ok()) return FromRocksdb(status, "reading key " + KeyAsHex(key));
  return value;
}

std::unique_ptr<rocksdb::Iterator> StateDatabase::Scan(Family family,
                                                       const rocksdb::Slice* upper_bound,
                                                       const rocksdb::Snapshot* snapshot) const {
  rocksdb::ReadOptions options;
  options.snapshot = snapshot;
  options.iterate_upper_bound = upper_bound;
  // A scan reads each block once, so it must not evict the blocks that point reads use.
  options.fill_cache = false;
  options.readahead_size = std::size_t{1} << 20;
  return std::unique_ptr<rocksdb::Iterator>(database_->NewIterator(options, handle(family)));
}

absl::Status StateDatabase::Verify() const {
  if (absl::Status status = FromRocksdb(database_->VerifyChecksum(), "verifying its tables");
      !status.ok()) {
    return status;
  }
  for (std::size_t index = 0; index < kFamilyNames.size(); ++index) {
    const auto family = static_cast<Family>(index);
    const KeyRange range = RangeOf(family);
    const rocksdb::Slice upper_bound(range.end);
    const std::unique_ptr<rocksdb::Iterator> scan = Scan(family, &upper_bound);
    for (scan->Seek(range.begin); scan->Valid(); scan->Next()) {
      const ValuePlace place{NameOf(family), scan->key().ToStringView()};
      const absl::StatusOr<std::string_view> payload = Unseal(place, scan->value().ToStringView());
      if (!payload.ok()) return payload.status();
    }
    if (absl::Status status = FromRocksdb(scan->status(), "reading its records"); !status.ok()) {
      return status;
    }
  }
  return absl::OkStatus();
}

absl::Status StateDatabase::Repair(const std::filesystem::path& folder,
                                   const SharedResources& shared) {
  return FromRocksdb(rocksdb::RepairDB(folder.string(), DatabaseOptions(shared), Families(shared)),
                     "repairing " + folder.string());
}

absl::Status StateDatabase::health() const {
  const absl::MutexLock lock(&health_->mutex);
  return health_->status;
}

}  // namespace steadymap
