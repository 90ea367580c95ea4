#include "server/store/map/content_loader.h"

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "core/types/parallel.h"
#include "core/volume/tsdf_codec.h"
#include "server/store/database/object_records.h"
#include "server/store/database/robot_records.h"
#include "server/store/database/store_keys.h"
#include "server/store/map/state_reading.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {
namespace {

/// Inserts records into a snapshot: objects first, then their leaves.
class ContentLoader {
 public:
  explicit ContentLoader(MapSnapshot* content) : content_(content) {}

  absl::Status LoadObject(const ValuePlace& place, std::string_view value) {
    const std::optional<ObjectId> id = ObjectOfKey(place.key);
    if (!id) return DamagedValue(place, "has a key that is not an object key");
    storage::v1::ObjectRecord record;
    if (absl::Status status = UnsealRecord(place, value, &record); !status.ok()) return status;
    absl::StatusOr<ObjectState> state = FromProto(*id, record.state());
    if (!state.ok()) return DamagedValue(place, std::string(state.status().message()));
    objects_[*id] = {*std::move(state), std::make_shared<TsdfGrid>()};
    return absl::OkStatus();
  }

  /// Buffers a leaf. `StoreLeaves` stores the buffered leaves.
  absl::Status LoadLeaf(const ValuePlace& place, std::string_view value) {
    waiting_leaves_.push_back({std::string(place.key), std::string(value)});
    return waiting_leaves_.size() < kLeavesAtOnce ? absl::OkStatus() : StoreLeaves();
  }

  /// Unpacks the buffered leaves on all cores and stores them. Returns the error of the first
  /// failed leaf.
  absl::Status StoreLeaves() {
    std::vector<LoadedLeaf> leaves(waiting_leaves_.size());
    ParallelFor(leaves.size(), kMinRangeLeaves, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        leaves[i].status = Unpack(waiting_leaves_[i], &leaves[i]);
      }
    });
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      if (!leaves[i].status.ok()) return leaves[i].status;
      if (absl::Status status = Store(waiting_leaves_[i].key, leaves[i]); !status.ok()) {
        return status;
      }
    }
    waiting_leaves_.clear();
    return absl::OkStatus();
  }

  absl::Status LoadFreeBlock(const ValuePlace& place, std::string_view value) {
    const std::optional<LeafOrigin> origin = FreeBlockOfKey(place.key);
    if (!origin) return DamagedValue(place, "has a key that is not a free-space key");
    storage::v1::FreeBlockRecord record;
    if (absl::Status status = UnsealRecord(place, value, &record); !status.ok()) return status;
    const absl::StatusOr<FreeBlock> block = FromProto(record);
    if (!block.ok()) return DamagedValue(place, std::string(block.status().message()));
    content_->free_space.StoreBlock(*origin, *block);
    return absl::OkStatus();
  }

  absl::Status LoadRobot(const ValuePlace& place, std::string_view value) {
    const std::optional<SensorName> sensor = SensorOfRobotKey(place.key);
    if (!sensor) return DamagedValue(place, "has a key that is not a robot key");
    storage::v1::RobotRecord record;
    if (absl::Status status = UnsealRecord(place, value, &record); !status.ok()) return status;
    const absl::StatusOr<RobotState> state = FromProto(record);
    if (!state.ok()) return DamagedValue(place, std::string(state.status().message()));
    content_->robots[*sensor] = *state;
    return absl::OkStatus();
  }

  void Finish() {
    for (auto& [id, object] : objects_) {
      content_->objects.insert_or_assign(
          id, std::make_shared<const MapObject>(MapObject{std::move(object.state), object.volume}));
    }
  }

 private:
  struct LoadedObject {
    ObjectState state;
    std::shared_ptr<TsdfGrid> volume;
  };

  // Some megabytes of unpacked leaves, which give each core several ranges.
  static constexpr std::size_t kLeavesAtOnce = 512;

  // Smallest number of leaves in a core's range: about 500 us of work.
  static constexpr std::size_t kMinRangeLeaves = 16;

  /// The stored key and value of a leaf.
  struct LeafValue {
    std::string key;
    std::string value;
  };

  struct LoadedLeaf {
    absl::Status status;
    LeafKey key;
    LeafVoxels voxels;
  };

  static ValuePlace PlaceOf(std::string_view key) { return {NameOf(Family::kLeaf), key}; }

  absl::Status Unpack(const LeafValue& stored, LoadedLeaf* leaf) const {
    const ValuePlace place = PlaceOf(stored.key);
    const std::optional<LeafKey> key = UnpackLeafKey(place.key);
    if (!key) return DamagedValue(place, "has a key that is not a leaf key");
    leaf->key = *key;
    storage::v1::LeafRecord record;
    if (absl::Status status = UnsealRecord(place, stored.value, &record); !status.ok()) {
      return status;
    }
    absl::Status status = UnpackLeaf(record.packed(), &leaf->voxels);
    if (status.ok()) return status;
    return DamagedValue(place, absl::StrCat("is not a valid leaf: ", status.message()));
  }

  absl::Status Store(std::string_view stored_key, const LoadedLeaf& leaf) {
    const LeafOrigin origin = leaf.key.origin;
    if (leaf.key.object == kBackgroundId) {
      content_->background.MutableTile(origin).StoreLeaf(origin, leaf.voxels);
      return absl::OkStatus();
    }
    const auto owner = objects_.find(leaf.key.object);
    if (owner == objects_.end()) {
      return DamagedValue(PlaceOf(stored_key), "is a leaf of an object that does not exist");
    }
    owner->second.volume->StoreLeaf(origin, leaf.voxels);
    return absl::OkStatus();
  }

  MapSnapshot* content_;
  std::map<ObjectId, LoadedObject> objects_;
  std::vector<LeafValue> waiting_leaves_;
};

}  // namespace

absl::Status LoadContent(const StateDatabase& state,
                         const rocksdb::Snapshot* snapshot,
                         MapSnapshot* content) {
  ContentLoader loader(content);
  using LoadRecord = absl::Status (ContentLoader::*)(const ValuePlace&, std::string_view);
  static constexpr std::array<std::pair<Family, LoadRecord>, 4> kLoads = {
      {{Family::kObject, &ContentLoader::LoadObject},
       {Family::kLeaf, &ContentLoader::LoadLeaf},
       {Family::kFree, &ContentLoader::LoadFreeBlock},
       {Family::kRobot, &ContentLoader::LoadRobot}}};
  for (const auto& [family, load] : kLoads) {
    const auto visit = [&loader, load = load](const ValuePlace& place, std::string_view value) {
      return (loader.*load)(place, value);
    };
    if (absl::Status status = ForEachRecord(state, family, snapshot, visit); !status.ok())
      return status;
  }
  if (absl::Status status = loader.StoreLeaves(); !status.ok()) return status;
  loader.Finish();
  return absl::OkStatus();
}

}  // namespace steadymap
