#include "server/store_database.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include <absl/strings/str_cat.h>
#include <rocksdb/cache.h>
#include <rocksdb/experimental.h>
#include <rocksdb/filter_policy.h>
#include <rocksdb/listener.h>
#include <rocksdb/table.h>
#include <rocksdb/write_batch.h>

#include "core/error.h"
#include "server/store_keys.h"
#include "server/torn_log.h"

namespace steadymap {
namespace {

rocksdb::Slice ToSlice(std::string_view bytes) { return {bytes.data(), bytes.size()}; }

absl::Status ReadOnly(const std::string& cause) {
  return MakeError(absl::StatusCode::kUnavailable,
                   reason::kStoreReadOnly,
                   "the store takes no more writes until the server is restarted: " + cause);
}

rocksdb::DBOptions DatabaseOptions(const StoreOptions& options, rocksdb::Env* environment) {
  rocksdb::DBOptions result;
  if (environment != nullptr) result.env = environment;
  result.create_if_missing = true;
  result.create_missing_column_families = true;
  // Of the recovery modes, only this one fits DURABLE. A torn end is a write that was under way
  // when the power went: nobody was told that it is durable, so it may go. A bad record before the
  // end was synced and acknowledged; point-in-time recovery (RocksDB's default) would drop it and
  // everything after it without a word. This mode refuses to open instead, and we say DATA_LOSS.
  // It would refuse some torn ends as well; `CutTornLog` has cut those off before.
  result.wal_recovery_mode = rocksdb::WALRecoveryMode::kTolerateCorruptedTailRecords;
  // Notices when a whole write-ahead log is missing or was cut short.
  result.track_and_verify_wals_in_manifest = true;
  result.paranoid_checks = true;
  // A failed write is never retried, so not behind our back either.
  result.max_bgerror_resume_count = 0;
  result.db_write_buffer_size = options.write_buffer_bytes;
  // A column family that is seldom written would else keep old write-ahead logs for ever; what they
  // hold is what a restart has to replay.
  result.max_total_wal_size = 2 * options.write_buffer_bytes;
  result.max_open_files = 256;
  result.max_background_jobs = 2;
  result.info_log_level = rocksdb::InfoLogLevel::WARN_LEVEL;
  result.max_log_file_size = std::size_t{1} << 20;
  result.keep_log_file_num = 2;
  result.stats_dump_period_sec = 0;
  result.stats_persist_period_sec = 0;
  return result;
}

rocksdb::ColumnFamilyOptions FamilyOptions(std::string_view name,
                                           const StoreOptions& options,
                                           const std::shared_ptr<rocksdb::Cache>& cache) {
  rocksdb::ColumnFamilyOptions result;
  rocksdb::BlockBasedTableOptions table;
  table.block_cache = cache;
  table.cache_index_and_filter_blocks = true;
  table.format_version = 5;
  result.table_factory.reset(rocksdb::NewBlockBasedTableFactory(table));
  result.write_buffer_size = options.write_buffer_bytes / 4;
  result.compression = rocksdb::kLZ4Compression;
  if (name == NameOf(Family::kLog)) {
    // Frames are written once and deleted in order: as blobs they are never copied by compactions.
    result.enable_blob_files = true;
    result.min_blob_size = 4096;
    result.blob_file_size = std::uint64_t{64} << 20;
    result.enable_blob_garbage_collection = true;
    result.compression = rocksdb::kNoCompression;
  }
  if (name == NameOf(Family::kLeaf))
    result.compression = rocksdb::kNoCompression;  // packed already
  return result;
}

}  // namespace

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

/// Remembers what goes wrong in RocksDB's own threads.
class StoreDatabase::ErrorListener final : public rocksdb::EventListener {
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

StoreDatabase::StoreDatabase(FolderLock lock, std::filesystem::path folder)
    : lock_(std::move(lock)), folder_(std::move(folder)) {}

absl::StatusOr<std::unique_ptr<StoreDatabase>> StoreDatabase::Open(
    const std::filesystem::path& folder, const StoreOptions& options, rocksdb::Env* environment) {
  absl::StatusOr<FolderLock> lock = FolderLock::Take(folder);
  if (!lock.ok()) return lock.status();
  if (absl::Status status = CheckSchema(folder); !status.ok()) return status;
  const std::filesystem::path database_folder = folder / "rocksdb";
  if (absl::Status status = CutTornLog(database_folder); !status.ok()) return status;
  std::unique_ptr<StoreDatabase> result(new StoreDatabase(*std::move(lock), folder));
  rocksdb::DBOptions database_options = DatabaseOptions(options, environment);
  database_options.listeners.push_back(std::make_shared<ErrorListener>(result->health_));
  const std::shared_ptr<rocksdb::Cache> cache = rocksdb::NewLRUCache(options.block_cache_bytes);
  std::vector<rocksdb::ColumnFamilyDescriptor> families;
  for (const std::string_view name : kFamilyNames) {
    families.emplace_back(std::string(name), FamilyOptions(name, options, cache));
  }
  families.emplace_back(rocksdb::kDefaultColumnFamilyName, rocksdb::ColumnFamilyOptions());
  rocksdb::DB* database = nullptr;
  std::vector<rocksdb::ColumnFamilyHandle*> handles;
  const rocksdb::Status status =
      rocksdb::DB::Open(database_options, database_folder.string(), families, &handles, &database);
  if (!status.ok()) return FromRocksdb(status, "opening " + folder.string());
  result->database_.reset(database);
  result->default_handle_ = handles.back();
  handles.pop_back();
  result->handles_ = std::move(handles);
  return result;
}

StoreDatabase::~StoreDatabase() {
  if (database_ == nullptr) return;
  // Failing to let go of a handle leaks it, no more; there is nobody left to tell.
  for (rocksdb::ColumnFamilyHandle* family : handles_) {
    database_->DestroyColumnFamilyHandle(family).PermitUncheckedError();
  }
  database_->DestroyColumnFamilyHandle(default_handle_).PermitUncheckedError();
  database_->Close().PermitUncheckedError();
}

absl::Status StoreDatabase::Write(rocksdb::WriteBatch* batch) {
  if (absl::Status status = health(); !status.ok()) return status;
  rocksdb::WriteOptions options;
  options.sync = true;
  const rocksdb::Status status = database_->Write(options, batch);
  if (status.ok()) return absl::OkStatus();
  const absl::MutexLock lock(&health_->mutex);
  if (health_->status.ok()) health_->status = ReadOnly(status.ToString());
  return health_->status;
}

absl::StatusOr<std::string> StoreDatabase::Read(Family family,
                                                std::string_view key,
                                                const rocksdb::Snapshot* snapshot) const {
  rocksdb::ReadOptions options;
  options.snapshot = snapshot;
  std::string value;
  const rocksdb::Status status = database_->Get(options, handle(family), ToSlice(key), &value);
  if (status.IsNotFound()) {
    return absl::NotFoundError(absl::StrCat("the store has no key ", KeyForPeople(key)));
  }
  if (!status.ok()) return FromRocksdb(status, "reading key " + KeyForPeople(key));
  return value;
}

std::unique_ptr<rocksdb::Iterator> StoreDatabase::Scan(Family family,
                                                       const rocksdb::Slice* upper_bound,
                                                       const rocksdb::Snapshot* snapshot) const {
  rocksdb::ReadOptions options;
  options.snapshot = snapshot;
  options.iterate_upper_bound = upper_bound;
  // A scan reads everything once; it must not push out what point reads use.
  options.fill_cache = false;
  options.readahead_size = std::size_t{1} << 20;
  return std::unique_ptr<rocksdb::Iterator>(database_->NewIterator(options, handle(family)));
}

void StoreDatabase::Reclaim(Family family, std::string_view begin, std::string_view end) {
  const rocksdb::Slice first = ToSlice(begin);
  const rocksdb::Slice last = ToSlice(end);
  // Only a hint: what it misses, later compactions find.
  rocksdb::experimental::SuggestCompactRange(database_.get(), handle(family), &first, &last)
      .PermitUncheckedError();
}

absl::StatusOr<std::uint64_t> StoreDatabase::FreeDiskBytes() const {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder_, error);
  if (error) {
    return MakeError(
        absl::StatusCode::kInternal,
        reason::kInternal,
        absl::StrCat("cannot tell the free space of ", folder_.string(), ": ", error.message()));
  }
  return space.available;
}

absl::Status StoreDatabase::health() const {
  const absl::MutexLock lock(&health_->mutex);
  return health_->status;
}

}  // namespace steadymap
