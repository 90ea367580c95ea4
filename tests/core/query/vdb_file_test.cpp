#include "core/query/vdb_file.h"

#include <map>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include "tests/support/analytic_map.h"

namespace steadymap {
namespace {

using ::steadymap::testing::BoxOverFloor;
using ::steadymap::testing::kBoxPlace;

using Grids = std::map<std::string, openvdb::GridBase::Ptr>;

Grids Read(const std::string& file) {
  openvdb::initialize();
  std::istringstream bytes(file, std::ios::binary);
  openvdb::io::Stream stream(bytes);
  Grids grids;
  for (const openvdb::GridBase::Ptr& grid : *stream.getGrids()) grids[grid->getName()] = grid;
  return grids;
}

TEST(WriteVdb, EveryVolumeHasItsGridsWithMetadata) {
  const Grids grids = Read(*WriteVdb(BoxOverFloor(), nullptr));
  ASSERT_EQ(grids.size(), 4U);
  ASSERT_TRUE(grids.contains("background/distance") && grids.contains("background/weight"));
  ASSERT_TRUE(grids.contains("object-3/distance") && grids.contains("object-3/weight"));
  const openvdb::GridBase& object = *grids.at("object-3/distance");
  EXPECT_EQ(object.metaValue<openvdb::Int64>("object_id"), 3);
  EXPECT_EQ(object.metaValue<std::int32_t>("class_id"), 103);
  EXPECT_EQ(object.metaValue<openvdb::Int64>("revision"), 7);
  EXPECT_EQ(object.metaValue<std::string>("standing"), "present");
  EXPECT_EQ(object.metaValue<double>("alpha"), 3.0);
  EXPECT_EQ(object.metaValue<double>("stationarity"), 0.75);
  EXPECT_EQ(grids.at("background/weight")->metaValue<openvdb::Int64>("object_id"), 0);
}

TEST(WriteVdb, TheTransformTakesAnObjectsVoxelsToTheWorld) {
  const MapSnapshot map = BoxOverFloor();
  const Grids grids = Read(*WriteVdb(map, nullptr));
  const Eigen::Isometry3d T_world_object = kBoxPlace.ToIsometry();
  for (const Eigen::Vector3d& voxel :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(10, 0, 0), Eigen::Vector3d(-3, 7, 5)}) {
    const Eigen::Vector3d truth = T_world_object * (voxel * map.scale.voxel_size_m);
    const openvdb::Vec3d found = grids.at("object-3/distance")
                                     ->transform()
                                     .indexToWorld(openvdb::Vec3d(voxel.x(), voxel.y(), voxel.z()));
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(found[axis], truth[axis], 1e-12);
  }
  EXPECT_EQ(grids.at("background/distance")->transform().indexToWorld(openvdb::Vec3d(2, 4, 6)),
            openvdb::Vec3d(0.1, 0.2, 6 * 0.05));
}

TEST(WriteVdb, TheBoxCutsObjectsInTheWorld) {
  const MapSnapshot map = BoxOverFloor();
  const Box box(Eigen::Vector3d(0.5, -1.0, 0.4), Eigen::Vector3d(2.0, 1.0, 2.0));
  const Grids grids = Read(*WriteVdb(map, &box));
  EXPECT_EQ(grids.at("background/distance")->activeVoxelCount(), 0U);
  const auto object = openvdb::gridPtrCast<openvdb::FloatGrid>(grids.at("object-3/distance"));
  EXPECT_GT(object->activeVoxelCount(), 100U);
  for (auto voxel = object->cbeginValueOn(); voxel; ++voxel) {
    const openvdb::Vec3d center = object->transform().indexToWorld(voxel.getCoord());
    ASSERT_TRUE(box.contains(Eigen::Vector3d(center.x(), center.y(), center.z())));
  }
}

TEST(WriteVdb, ChosenVolumesAloneAreWritten) {
  const MapSnapshot map = BoxOverFloor();
  const std::vector<PlacedVolume> chosen = {VolumeOf(*map.objects.at(ObjectId(3)))};
  const Grids grids = Read(*WriteVdb(map, chosen, nullptr));
  EXPECT_EQ(grids.size(), 2U);
  EXPECT_FALSE(grids.contains("background/distance"));
}

}  // namespace
}  // namespace steadymap
