#include "client/map/map_section_reader.h"

#include <map>
#include <memory>
#include <utility>

#include "client/transport/protocol_error.h"
#include "core/types/error.h"
#include "core/volume/tsdf_codec.h"
#include "core/volume/tsdf_grid.h"
#include "proto/convert_object.h"

namespace steadymap {
namespace {

/// A map section, built message by message.
class SectionBuilder {
 public:
  absl::Status Take(const v1::GetMapSectionResponse& message) {
    if (message.has_header()) return TakeHeader(message.header());
    if (!has_header_) return ProtocolError("the server sent a map section without a header");
    if (message.has_objects()) return TakeObjects(message.objects());
    return TakeLeaves(message.leaves());
  }

  MapSnapshot Finish() {
    for (auto& [id, object] : objects_) {
      object.second.volume = std::move(object.first);
      section_.objects.insert_or_assign(
          id, std::make_shared<const MapObject>(std::move(object.second)));
    }
    return std::move(section_);
  }

 private:
  absl::Status TakeHeader(const v1::GetMapSectionResponse::Header& header) {
    if (has_header_) return ProtocolError("the server sent a map section with two headers");
    if (!(header.voxel_size_m() > 0.0 && header.truncation_m() > 0.0)) {
      return ProtocolError("the server sent a map section with an invalid voxel size");
    }
    section_ = MapSnapshot({header.voxel_size_m(), header.truncation_m()});
    section_.revision = Revision(header.revision());
    has_header_ = true;
    return absl::OkStatus();
  }

  absl::Status TakeObjects(const v1::GetMapSectionResponse::Objects& objects) {
    for (const v1::Object& message : objects.objects()) {
      absl::StatusOr<ObjectState> state = FromProto(message);
      if (!state.ok()) return state.status();
      const ObjectId id = state->id;
      objects_[id] = {std::make_shared<TsdfGrid>(), MapObject{*std::move(state), nullptr}};
    }
    return absl::OkStatus();
  }

  absl::Status TakeLeaves(const v1::GetMapSectionResponse::Leaves& leaves) {
    LeafVoxels voxels;
    for (const v1::PackedLeaf& leaf : leaves.leaves()) {
      const LeafOrigin origin{leaf.origin_x(), leaf.origin_y(), leaf.origin_z()};
      if (origin != LeafOf(origin.x, origin.y, origin.z)) {
        return ProtocolError("the server sent a leaf whose origin is not a multiple of 8");
      }
      absl::Status status = UnpackLeaf(leaf.packed(), &voxels);
      if (!status.ok()) return status;
      if (ObjectId(leaf.object_id()) == kBackgroundId) {
        section_.background.MutableTile(origin).StoreLeaf(origin, voxels);
        continue;
      }
      const auto object = objects_.find(ObjectId(leaf.object_id()));
      if (object == objects_.end()) {
        return ProtocolError("the server sent a leaf of an unknown object");
      }
      object->second.first->StoreLeaf(origin, voxels);
    }
    return absl::OkStatus();
  }

  bool has_header_ = false;
  MapSnapshot section_;
  /// The volumes under construction and the states they belong to.
  std::map<ObjectId, std::pair<std::shared_ptr<TsdfGrid>, MapObject>> objects_;
};

}  // namespace

absl::StatusOr<MapSnapshot> ReadMapSection(
    grpc::ClientReaderInterface<v1::GetMapSectionResponse>* stream) {
  SectionBuilder builder;
  v1::GetMapSectionResponse response;
  while (stream->Read(&response)) {
    if (absl::Status status = builder.Take(response); !status.ok()) return status;
  }
  return builder.Finish();
}

}  // namespace steadymap
