#pragma once

#include <functional>
#include <map>
#include <memory>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>

#include "server/store/model/store.h"

namespace steadymap {

/// A store without a disk, for tests: it satisfies the contract of `Store` (the same suite runs
/// against both) and fails on request. Its content outlives a server with a `Share()` of it, like a
/// disk.
///
/// Thread-safe.
class MemoryStore final : public Store {
 public:
  explicit MemoryStore(const StoreOptions& options = {});
  ~MemoryStore() override;

  /// Returns a second store with the same content: pass it to a server and keep this one for
  /// inspection and control.
  std::unique_ptr<MemoryStore> Share() const;

  /// The next append or commit fails like a failed sync, and its map accepts no more writes until
  /// it is loaded again; loading fails before `Repair`.
  void FailNextAppend();
  void FailNextCommit();
  void Repair();

  /// Appends, commits and new maps fail with `DISK_LOW` while `low` is true.
  void SetDiskLow(bool low);

  /// Calls `is_low` (none: null) before every append; if it returns true, the append fails with
  /// `DISK_LOW`. Called under the store's lock. The function owns its state: a server appends what
  /// is in its queue after the streams of the test have ended.
  void SetDiskLowFor(std::function<bool()> is_low);

  /// Makes a map's volumes unreadable: `LoadMap` fails with `DataLoss`.
  void DamageMap(MapKey map);

  /// Calls `hook` (none: null) in every append and commit before anything is stored, without any
  /// lock held; a test can block the writer in it.
  void SetWriteHook(std::function<void()> hook);

  /// Number of entries in the log of `map`.
  std::size_t log_size(MapKey map) const;

  absl::StatusOr<MapRecord> CreateMap(const MapRecord& record) override;
  absl::Status UpdateMap(const MapRecord& record) override;
  absl::Status DeleteMap(MapKey map) override;
  absl::StatusOr<std::vector<MapRecord>> ListMaps() override;
  absl::StatusOr<StoredState> LoadMap(const MapRecord& record) override;
  absl::Status Append(const LogAppend& append) override;
  absl::StatusOr<CommitMark> CommitRevision(MapKey map,
                                            const MapDelta& delta,
                                            const CommitDetails& details) override;
  absl::Status ReadLog(MapKey map,
                       MapSequence first,
                       const std::function<absl::Status(LogEntry)>& visit) override;
  absl::StatusOr<std::vector<FramePose>> ReadPoses(MapKey map,
                                                   MapSequence first,
                                                   MapSequence last,
                                                   std::size_t limit) override;
  absl::StatusOr<std::vector<StoredEvent>> ReadEvents(MapKey map,
                                                      EventNumber first,
                                                      std::size_t limit) override;
  absl::StatusOr<ChangeList> ReadChanges(MapKey map, CommitMark from, Revision to) override;
  absl::Status Trim(const MapRecord& map, const TrimBounds& bounds) override;
  absl::Status health(MapKey map) const override;
  absl::Status CheckDisk() const override;

 private:
  struct Content;
  struct StoredMap;

  explicit MemoryStore(std::shared_ptr<Content> content);

  std::shared_ptr<Content> content_;
};

}  // namespace steadymap
