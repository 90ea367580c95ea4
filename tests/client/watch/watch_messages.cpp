#include "tests/client/watch/watch_messages.h"

#include <memory>

#include "core/map/map_delta.h"
#include "core/volume/tsdf_codec.h"
#include "proto/convert_event.h"
#include "proto/convert_geometry.h"
#include "proto/convert_object.h"
#include "tests/support/analytic_map.h"

namespace steadymap::watching {
namespace {

v1::PackedLeaf LeafMessage(const LeafKey& key, const std::string& packed) {
  v1::PackedLeaf leaf;
  leaf.set_object_id(key.object.value());
  leaf.set_origin_x(key.origin.x);
  leaf.set_origin_y(key.origin.y);
  leaf.set_origin_z(key.origin.z);
  leaf.set_packed(packed);
  return leaf;
}

MapObject BoxAt(std::uint64_t id, double x) {
  MapObject object = testing::BoxObject(
      ObjectId(id), Eigen::Vector3d(0.3, 0.2, 0.2), {Eigen::Vector3d(x, 0.5, 0.6), 0.3});
  object.revision = Revision(id);
  object.supporting_frames = 10 * id;
  return object;
}

}  // namespace

Messages Join(const std::vector<Messages>& parts) {
  Messages all;
  for (const Messages& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

Messages Created(const MapSnapshot& map, const std::string& incarnation) {
  Messages messages(1);
  v1::WatchCreated& created = *messages[0].mutable_created();
  created.set_revision(map.revision.value());
  created.set_voxel_size_m(map.scale.voxel_size_m);
  created.set_truncation_m(map.scale.truncation_m);
  created.set_incarnation(incarnation);
  return messages;
}

Messages SnapshotOf(const MapSnapshot& map, std::size_t max_leaves) {
  Messages messages(1);
  v1::SnapshotChunk* chunk = messages[0].mutable_snapshot();
  chunk->set_revision(map.revision.value());
  for (const auto& [id, object] : map.objects) *chunk->add_objects() = ToProto(*object);
  for (const auto& [key, packed] : ContentOf(map).leaves) {
    if (static_cast<std::size_t>(chunk->leaves_size()) == max_leaves) {
      chunk = messages.emplace_back().mutable_snapshot();
      chunk->set_revision(map.revision.value());
    }
    *chunk->add_leaves() = LeafMessage(key, packed);
  }
  return messages;
}

Messages DeltaOf(const MapSnapshot& before, const MapSnapshot& after, std::uint32_t fragments) {
  const MapDelta delta = Diff(before, after);
  Messages messages(fragments);
  for (std::uint32_t i = 0; i < fragments; ++i) {
    v1::DeltaFragment& fragment = *messages[i].mutable_delta();
    fragment.set_revision(after.revision.value());
    fragment.set_previous_revision(before.revision.value());
    fragment.set_commits(1);
    fragment.set_fragment(i + 1);
    fragment.set_fragments(fragments);
  }
  v1::DeltaFragment& first = *messages[0].mutable_delta();
  for (const ObjectChange& change : delta.objects) {
    if (change.state) {
      *first.add_objects() = ToProto(*after.objects.at(change.id));
    } else {
      first.add_removed_object_ids(change.id.value());
    }
  }
  for (std::size_t i = 0; i < delta.leaves.size(); ++i) {
    const LeafChange& change = delta.leaves[i];
    v1::DeltaFragment& fragment = *messages[i * fragments / delta.leaves.size()].mutable_delta();
    *fragment.add_leaves() = LeafMessage(change.key, change.packed);
  }
  return messages;
}

Messages Events(std::uint64_t revision, const std::vector<std::uint64_t>& numbers) {
  Messages messages(1);
  v1::EventBatch& batch = *messages[0].mutable_events();
  batch.set_revision(revision);
  for (const std::uint64_t number : numbers) {
    ObjectEvent event;
    event.object = ObjectId(3);
    event.revision = Revision(revision);
    event.time = Timestamp::FromSeconds(100.0 + static_cast<double>(number));
    *batch.add_events() = ToProto(EventNumber(number), event);
  }
  return messages;
}

Messages Progress(std::uint64_t revision, const std::string& token) {
  Messages messages(1);
  messages[0].mutable_progress()->set_revision(revision);
  messages[0].mutable_progress()->set_resume_token(token);
  messages[0].mutable_progress()->mutable_last_capture_time()->set_seconds(
      static_cast<std::int64_t>(10 * revision));
  return messages;
}

Messages Resync(std::uint64_t revision) {
  Messages messages(1);
  messages[0].mutable_resync()->set_revision(revision);
  messages[0].mutable_resync()->set_reason("REVISION_COMPACTED");
  return messages;
}

Messages Goodbye(std::int64_t reconnect_after_s) {
  Messages messages(1);
  messages[0].mutable_goodbye()->mutable_reconnect_after()->set_seconds(reconnect_after_s);
  return messages;
}

MapContent ContentOf(const MapSnapshot& map) {
  MapContent content;
  content.revision = map.revision.value();
  const auto add = [&](ObjectId owner, const VoxelReader& volume) {
    volume.ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
      content.leaves[{owner, origin}] = PackLeaf(leaf);
    });
  };
  add(kBackgroundId, map.background);
  for (const auto& [id, object] : map.objects) {
    content.objects[id.value()] = ToProto(*object).SerializeAsString();
    add(id, *object->volume);
  }
  return content;
}

MapSnapshot FirstMap() {
  MapSnapshot map = testing::FloorMap();
  map.revision = Revision(5);
  map.last_capture_time = Timestamp::FromSeconds(50.0);
  testing::AddObject(BoxAt(1, -1.0), &map);
  testing::AddObject(BoxAt(2, 0.0), &map);
  return map;
}

MapSnapshot SecondMap() {
  MapSnapshot map = FirstMap();
  map.revision = Revision(6);
  map.last_capture_time = Timestamp::FromSeconds(60.0);
  map.objects.erase(ObjectId(1));
  auto changed = std::make_shared<MapObject>(*map.objects.at(ObjectId(2)));
  changed->belief.alpha += 1.0;
  changed->revision = Revision(6);
  map.objects.insert_or_assign(ObjectId(2), std::move(changed));
  testing::AddObject(BoxAt(3, 1.0), &map);
  LeafVoxels voxels;
  map.background.MutableTile({0, 0, 0}).LoadLeaf({0, 0, 0}, &voxels);
  map.background.MutableTile({0, 0, 64}).StoreLeaf({0, 0, 64}, voxels);
  map.background.MutableTile({0, 0, 0}).StoreLeaf({0, 0, 0}, LeafVoxels());
  return map;
}

}  // namespace steadymap::watching
