#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "core/error.h"
#include "core/tsdf_codec.h"
#include "proto/convert_geometry.h"
#include "server/query_answers.h"
#include "server/query_selection.h"

namespace steadymap {
namespace {

constexpr std::size_t kMaxMessageBytes = std::size_t{1} << 20;

// What a packed leaf can take at most, and what surrounds it on the wire.
constexpr std::size_t kMaxLeafBytes = 8192;

/// Whether the centres of the leaf's voxels reach into `box`.
bool Touches(LeafOrigin origin, const VoxelScale& scale, const Box& box) {
  const Eigen::Vector3d low = scale.voxel_size_m * Eigen::Vector3d(origin.x, origin.y, origin.z);
  const double reach_m = scale.voxel_size_m * (kLeafSide - 1);
  return box.intersects(Box(low, low + Eigen::Vector3d::Constant(reach_m)));
}

class MapSection final : public MessageSource<v1::GetMapSectionResponse> {
 public:
  MapSection(std::shared_ptr<const MapSnapshot> snapshot, std::vector<LeafOrigin> leaves)
      : snapshot_(std::move(snapshot)), leaves_(std::move(leaves)) {}

  absl::StatusOr<bool> Next(v1::GetMapSectionResponse* message) override {
    if (!header_sent_) {
      header_sent_ = true;
      v1::GetMapSectionResponse::Header* header = message->mutable_header();
      header->set_revision(snapshot_->revision.value());
      header->set_voxel_size_m(snapshot_->scale.voxel_size_m);
      header->set_truncation_m(snapshot_->scale.truncation_m);
      return true;
    }
    if (next_ == leaves_.size()) return false;
    std::size_t bytes = 0;
    while (next_ < leaves_.size() && bytes + kMaxLeafBytes <= kMaxMessageBytes) {
      v1::PackedLeaf* leaf = message->mutable_leaves()->add_leaves();
      Pack(leaves_[next_++], leaf);
      bytes += leaf->ByteSizeLong();
    }
    return true;
  }

 private:
  void Pack(LeafOrigin origin, v1::PackedLeaf* leaf) const {
    leaf->set_object_id(kBackgroundId.value());
    leaf->set_origin_x(origin.x);
    leaf->set_origin_y(origin.y);
    leaf->set_origin_z(origin.z);
    leaf->set_packed(PackLeaf(snapshot_->background.FindLeaf(origin), snapshot_->scale));
  }

  const std::shared_ptr<const MapSnapshot> snapshot_;
  const std::vector<LeafOrigin> leaves_;
  bool header_sent_ = false;
  std::size_t next_ = 0;
};

}  // namespace

absl::StatusOr<std::unique_ptr<MessageSource<v1::GetMapSectionResponse>>> OpenMapSection(
    std::shared_ptr<const MapSnapshot> snapshot, const v1::GetMapSectionRequest& request) {
  const absl::StatusOr<std::optional<Box>> box =
      ReadBox(request.has_box() ? &request.box() : nullptr);
  if (!box.ok()) return box.status();
  if (absl::Status status = CheckObjects(request.object_ids()); !status.ok()) return status;
  std::vector<LeafOrigin> leaves;
  snapshot->background.ForEachLeaf([&](LeafOrigin origin, const LeafView&) {
    if (!*box || Touches(origin, snapshot->scale, **box)) leaves.push_back(origin);
  });
  return std::make_unique<MapSection>(std::move(snapshot), std::move(leaves));
}

}  // namespace steadymap
