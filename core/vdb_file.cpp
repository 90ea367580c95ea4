#include "core/vdb_file.h"

#include <algorithm>
#include <mutex>
#include <sstream>

#include <openvdb/io/Stream.h>

#include "core/error.h"
#include "core/tsdf_trees.h"

namespace steadymap {
namespace {

// Where an OpenVDB file keeps the UUID that it draws at random: behind the magic number (8 bytes),
// the format and two library versions (4 each) and the offsets flag (1).
constexpr std::size_t kUuidPosition = 8 + 3 * 4 + 1;
constexpr std::size_t kUuidLength = 36;

void InitializeOpenVdb() {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
}

/// The grids of one volume, as stock types in world metres.
struct VolumeGrids {
  openvdb::FloatGrid::Ptr distance;
  openvdb::FloatGrid::Ptr weight;
  openvdb::Vec3fGrid::Ptr color = openvdb::Vec3fGrid::create(openvdb::Vec3f(0.0F));
  bool has_color = false;

  explicit VolumeGrids(const VoxelScale& scale)
      : distance(openvdb::FloatGrid::create(static_cast<float>(scale.truncation_m))),
        weight(openvdb::FloatGrid::create(0.0F)) {}
};

openvdb::Vec3f ToVec3f(std::uint32_t color) {
  const auto channel = [color](int shift) {
    return static_cast<float>((color >> shift) & 0xFFU) / 255.0F;
  };
  return {channel(0), channel(8), channel(16)};
}

void AddLeaf(LeafOrigin origin,
             const LeafView& leaf,
             const VoxelScale& scale,
             const Box* box,
             VolumeGrids* grids) {
  openvdb::FloatGrid::TreeType::LeafNodeType* distance = nullptr;
  openvdb::FloatGrid::TreeType::LeafNodeType* weight = nullptr;
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    if (!IsSet(leaf.observed, offset)) continue;
    const openvdb::Coord voxel = ToCoord(origin).offsetBy(static_cast<int>(offset >> 6),
                                                          static_cast<int>((offset >> 3) & 7),
                                                          static_cast<int>(offset & 7));
    if (box != nullptr &&
        !box->contains(Eigen::Vector3d(voxel.x(), voxel.y(), voxel.z()) * scale.voxel_size_m)) {
      continue;
    }
    if (distance == nullptr) {
      distance = grids->distance->tree().touchLeaf(voxel);
      weight = grids->weight->tree().touchLeaf(voxel);
    }
    const auto index = static_cast<openvdb::Index>(offset);
    distance->setValueOn(index, leaf.distance_m[offset]);
    weight->setValueOn(index, leaf.weight[offset]);
    if (leaf.color == nullptr || (leaf.color[offset] >> 24) == 0) continue;
    grids->has_color = true;
    grids->color->tree().setValueOn(voxel, ToVec3f(leaf.color[offset]));
  }
}

void Describe(const MapSnapshot& snapshot, const std::string& name, openvdb::GridBase* grid) {
  grid->setName(name);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(snapshot.scale.voxel_size_m));
  grid->insertMeta("class_id", openvdb::Int32Metadata(0));
  grid->insertMeta("revision",
                   openvdb::Int64Metadata(static_cast<std::int64_t>(snapshot.revision.value())));
  grid->insertMeta("voxel_size_m", openvdb::DoubleMetadata(snapshot.scale.voxel_size_m));
  grid->insertMeta("truncation_m", openvdb::DoubleMetadata(snapshot.scale.truncation_m));
}

std::string Serialize(const openvdb::GridPtrVec& grids) {
  std::ostringstream bytes(std::ios::binary);
  openvdb::io::Stream stream(bytes);
  stream.setCompression(openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
  stream.write(grids);
  std::string file = std::move(bytes).str();
  // Equal maps must give equal files.
  std::fill_n(file.begin() + kUuidPosition, kUuidLength, '0');
  for (const std::size_t dash : {8, 13, 18, 23}) file[kUuidPosition + dash] = '-';
  return file;
}

}  // namespace

absl::StatusOr<std::string> WriteVdb(const MapSnapshot& snapshot, const Box* box) {
  try {
    InitializeOpenVdb();
    VolumeGrids volume(snapshot.scale);
    snapshot.background.ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
      AddLeaf(origin, leaf, snapshot.scale, box, &volume);
    });
    volume.distance->setGridClass(openvdb::GRID_LEVEL_SET);
    Describe(snapshot, "background/distance", volume.distance.get());
    Describe(snapshot, "background/weight", volume.weight.get());
    openvdb::GridPtrVec grids = {volume.distance, volume.weight};
    if (volume.has_color) {
      Describe(snapshot, "background/color", volume.color.get());
      grids.push_back(volume.color);
    }
    return Serialize(grids);
  } catch (const std::exception& error) {
    return MakeError(absl::StatusCode::kInternal,
                     reason::kInternal,
                     std::string("OpenVDB could not write the map: ") + error.what());
  }
}

}  // namespace steadymap
