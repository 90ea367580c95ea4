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

/// A store without a disk, for tests: it keeps the contract of `Store` (the same suite runs against
/// both) and fails when it is told to. What it holds outlives a server that is given a `Share()` of
/// it, as a disk would.
///
/// Thread-safe.
class MemoryStore final : public Store {
 public:
  explicit MemoryStore(const StoreOptions& options = {});
  ~MemoryStore() override;

  /// A second store over the same content: give it to a server, keep this one to look and to steer.
  std::unique_ptr<MemoryStore> Share() const;

  /// The next append, or commit, fails as a failed sync does, and its map takes no more writes
  /// until it is loaded again; it cannot be loaded before `Repair`.
  void FailNextAppend();
  void FailNextCommit();
  void Repair();

  /// Appends, commits and new maps are refused with `DISK_LOW` while `low`.
  void SetDiskLow(bool low);

  /// Asks `is_low` (none: null) before every append; true refuses that one with `DISK_LOW`. Called
  /// under the store's lock.
  void SetDiskLowFor(std::function<bool()> is_low);

  /// Makes a map's volumes unreadable: `LoadMap` answers `DataLoss`.
  void DamageMap(MapKey map);

  /// Calls `hook` (none: null) in every append and commit, before anything is stored, without any
  /// lock: a test can hold the writer there.
  void SetWriteHook(std::function<void()> hook);

  /// Entries in the log of `map`.
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
