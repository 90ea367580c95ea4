#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/types/error.h"
#include "server/store/model/store.h"
#include "tests/watch/map_history.h"

namespace steadymap {

/// A store that records every commit of its only map in a history, and that can be killed:
/// afterwards nothing is written, as if the process had ended. Thread-safe.
class RecordingStore final : public Store {
 public:
  /// `history` and `killed` must outlive the store.
  RecordingStore(std::unique_ptr<Store> store, MapHistory* history, const std::atomic<bool>* killed)
      : store_(std::move(store)), history_(history), killed_(killed) {}

  absl::StatusOr<MapRecord> CreateMap(const MapRecord& record) override {
    return store_->CreateMap(record);
  }

  absl::Status UpdateMap(const MapRecord& record) override { return store_->UpdateMap(record); }

  absl::Status DeleteMap(MapKey map) override { return store_->DeleteMap(map); }

  absl::StatusOr<std::vector<MapRecord>> ListMaps() override { return store_->ListMaps(); }

  absl::StatusOr<StoredState> LoadMap(const MapRecord& record) override {
    return store_->LoadMap(record);
  }

  absl::Status Append(const LogAppend& append) override {
    return *killed_ ? KilledError() : store_->Append(append);
  }

  absl::StatusOr<CommitMark> CommitRevision(MapKey map,
                                            const MapDelta& delta,
                                            const CommitDetails& details) override {
    if (*killed_) return KilledError();
    absl::StatusOr<CommitMark> mark = store_->CommitRevision(map, delta, details);
    if (mark.ok() && delta.to > delta.from) history_->Add(delta);
    return mark;
  }

  absl::Status ReadLog(MapKey map,
                       MapSequence first,
                       const std::function<absl::Status(LogEntry)>& visit) override {
    return store_->ReadLog(map, first, visit);
  }

  absl::StatusOr<std::vector<FramePose>> ReadPoses(MapKey map,
                                                   MapSequence first,
                                                   MapSequence last,
                                                   std::size_t limit) override {
    return store_->ReadPoses(map, first, last, limit);
  }

  absl::StatusOr<std::vector<StoredEvent>> ReadEvents(MapKey map,
                                                      EventNumber first,
                                                      std::size_t limit) override {
    return store_->ReadEvents(map, first, limit);
  }

  absl::StatusOr<ChangeList> ReadChanges(MapKey map, CommitMark from, Revision to) override {
    return store_->ReadChanges(map, from, to);
  }

  absl::Status Trim(const MapRecord& map, const TrimBounds& bounds) override {
    return *killed_ ? KilledError() : store_->Trim(map, bounds);
  }

  absl::Status health(MapKey map) const override { return store_->health(map); }

  absl::Status CheckDisk() const override { return store_->CheckDisk(); }

 private:
  static absl::Status KilledError() {
    return MakeError(absl::StatusCode::kUnavailable, reason::kStoreReadOnly, "killed by the test");
  }

  const std::unique_ptr<Store> store_;
  MapHistory* const history_;
  const std::atomic<bool>* const killed_;
};

}  // namespace steadymap
