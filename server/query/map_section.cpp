#include "server/query/map_section.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "core/volume/tsdf_codec.h"
#include "proto/convert_object.h"
#include "server/query/query_selection.h"

namespace steadymap {
namespace {

constexpr std::size_t kSectionMessageBytes = std::size_t{1} << 20;

// Maximum size of a packed leaf in a message.
constexpr std::size_t kSectionLeafBytes = 8192;

// An object has about 300 bytes, and more if it was observed with many classes.
constexpr std::size_t kMaxObjectBytes = std::size_t{1} << 19;

/// The leaves of one volume in a section.
struct SectionPart {
  PlacedVolume volume;
  std::vector<LeafOrigin> leaves;
};

/// Returns the leaves of the chosen volumes that touch the box. Omits volumes without leaves in it.
absl::StatusOr<std::vector<SectionPart>> ChooseParts(const MapSnapshot& snapshot,
                                                     const std::vector<PlacedVolume>& volumes,
                                                     const std::optional<Box>& box,
                                                     const Cancellation& cancellation) {
  std::vector<SectionPart> parts;
  for (const PlacedVolume& volume : volumes) {
    SectionPart part{volume, {}};
    const bool finished = volume.voxels->VisitLeaves([&](LeafOrigin origin, const LeafView&) {
      if (!box || LeafTouches(volume, origin, snapshot.scale, *box)) part.leaves.push_back(origin);
      return !cancellation.IsCancelled();
    });
    if (!finished) return absl::CancelledError("the call was cancelled");
    if (!box || !part.leaves.empty()) parts.push_back(std::move(part));
  }
  return parts;
}

class MapSection final : public MessageSource<v1::GetMapSectionResponse> {
 public:
  MapSection(std::shared_ptr<const MapSnapshot> snapshot, std::vector<SectionPart> parts)
      : snapshot_(std::move(snapshot)), parts_(std::move(parts)) {}

  absl::StatusOr<bool> Next(v1::GetMapSectionResponse* message) override {
    if (!header_sent_) {
      header_sent_ = true;
      v1::GetMapSectionResponse::Header* header = message->mutable_header();
      header->set_revision(snapshot_->revision.value());
      header->set_voxel_size_m(snapshot_->scale.voxel_size_m);
      header->set_truncation_m(snapshot_->scale.truncation_m);
      return true;
    }
    return NextObjects(message) || NextLeaves(message);
  }

 private:
  /// Fills a message with objects. Returns false if none is left.
  bool NextObjects(v1::GetMapSectionResponse* message) {
    std::size_t bytes = 0;
    for (; next_object_ < parts_.size() && bytes < kMaxObjectBytes; ++next_object_) {
      const MapObject* object = parts_[next_object_].volume.object;
      if (object == nullptr) continue;
      v1::Object* added = message->mutable_objects()->add_objects();
      *added = ToProto(*object);
      bytes += added->ByteSizeLong();
    }
    return bytes > 0;
  }

  /// Fills a message with leaves. Returns false if none is left.
  bool NextLeaves(v1::GetMapSectionResponse* message) {
    std::size_t bytes = 0;
    while (part_ < parts_.size() && bytes + kSectionLeafBytes <= kSectionMessageBytes) {
      const SectionPart& part = parts_[part_];
      if (next_leaf_ == part.leaves.size()) {
        ++part_;
        next_leaf_ = 0;
        continue;
      }
      v1::PackedLeaf* leaf = message->mutable_leaves()->add_leaves();
      Pack(part.volume, part.leaves[next_leaf_++], leaf);
      bytes += leaf->ByteSizeLong();
    }
    return bytes > 0;
  }

  void Pack(const PlacedVolume& volume, LeafOrigin origin, v1::PackedLeaf* leaf) const {
    leaf->set_object_id(volume.id().value());
    leaf->set_origin_x(origin.x);
    leaf->set_origin_y(origin.y);
    leaf->set_origin_z(origin.z);
    leaf->set_packed(PackLeaf(volume.voxels->FindLeaf(origin)));
  }

  const std::shared_ptr<const MapSnapshot> snapshot_;
  const std::vector<SectionPart> parts_;  ///< Points into the snapshot.
  bool header_sent_ = false;
  std::size_t next_object_ = 0;  ///< Index in `parts_`.
  std::size_t part_ = 0;         ///< Index of the part of the next leaf.
  std::size_t next_leaf_ = 0;    ///< Index in the leaves of that part.
};

}  // namespace

absl::StatusOr<std::unique_ptr<MessageSource<v1::GetMapSectionResponse>>> OpenMapSection(
    std::shared_ptr<const MapSnapshot> snapshot,
    const v1::GetMapSectionRequest& request,
    const Cancellation& cancellation) {
  const absl::StatusOr<std::optional<Box>> box =
      ReadBox(request.has_box() ? &request.box() : nullptr);
  if (!box.ok()) return box.status();
  const absl::StatusOr<std::vector<PlacedVolume>> volumes =
      SelectVolumes(*snapshot, request.object_ids());
  if (!volumes.ok()) return volumes.status();
  absl::StatusOr<std::vector<SectionPart>> parts =
      ChooseParts(*snapshot, *volumes, *box, cancellation);
  if (!parts.ok()) return parts.status();
  return std::make_unique<MapSection>(std::move(snapshot), *std::move(parts));
}

}  // namespace steadymap
