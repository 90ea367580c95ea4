#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <openvdb/io/File.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include "core/query/vdb_file.h"
#include "tests/core/query/stock_vdb.h"
#include "tests/core/volume/random_leaf.h"
#include "tests/support/analytic_map.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using ::steadymap::testing::AddObject;
using ::steadymap::testing::BoxOverFloor;
using ::steadymap::testing::WriteStockVdb;

/// Returns leaves on both sides of the node borders of a stock tree, and far from the origin.
std::vector<LeafOrigin> LeavesAroundNodeBorders() {
  std::vector<LeafOrigin> origins;
  for (const std::int32_t x : {-4104, -8, 0, 120, 4096}) {
    for (const std::int32_t y : {-136, -128, 0, 8, 100'000}) {
      for (const std::int32_t z : {-8, 0, 4088}) origins.push_back({x, y, z});
    }
  }
  return origins;
}

/// Returns an object with leaves at `origins`, filled with random voxels.
MapObject ObjectOf(std::uint64_t id,
                   const std::vector<LeafOrigin>& origins,
                   bool color,
                   std::mt19937* random) {
  TsdfGrid volume;
  for (const LeafOrigin& origin : origins) {
    const LeafVoxels voxels = RandomLeaf(random, 0.3, true, color);
    volume.StoreLeaf(origin, voxels);
  }
  MapObject object;
  object.id = ObjectId(id);
  object.status = ObjectStatus::kPresent;
  object.class_id = ClassId(static_cast<std::uint16_t>(100 + id));
  object.T_world_object = {{1.0, -2.0 * static_cast<double>(id), 3.0}, 0.3};
  object.supporting_frames = id;
  object.volume = std::make_shared<const TsdfGrid>(std::move(volume));
  return object;
}

/// Returns a map with a background of several tiles, objects with and without colour, and an object
/// without voxels.
MapSnapshot RandomMap() {
  std::mt19937 random(7);
  MapSnapshot map;
  map.revision = Revision(12);
  for (const LeafOrigin& origin : LeavesAroundNodeBorders()) {
    map.background.MutableTile(origin).StoreLeaf(origin, RandomLeaf(&random, 0.2, false, false));
  }
  AddObject(ObjectOf(1, LeavesAroundNodeBorders(), true, &random), &map);
  AddObject(ObjectOf(2, {{-8, -8, -8}, {0, 0, 0}}, false, &random), &map);
  AddObject(ObjectOf(3, {}, false, &random), &map);
  AddObject(ObjectOf(4, {{8, 16, 24}}, true, &random), &map);
  return map;
}

/// Returns forty objects, each around the origin of its frame. Their file has many pieces.
MapSnapshot ManyObjects() {
  std::mt19937 random(3);
  MapSnapshot map;
  std::vector<LeafOrigin> corners;
  for (const std::int32_t x : {-8, 0}) {
    for (const std::int32_t y : {-8, 0}) {
      for (const std::int32_t z : {-8, 0}) corners.push_back({x, y, z});
    }
  }
  for (std::uint64_t id = 1; id <= 40; ++id) {
    AddObject(ObjectOf(id, corners, id % 2 == 0, &random), &map);
  }
  return map;
}

openvdb::GridPtrVec ReadGrids(const std::string& file) {
  openvdb::initialize();
  std::istringstream bytes(file, std::ios::binary);
  openvdb::io::Stream stream(bytes);
  return *stream.getGrids();
}

/// Expects the grids of `WriteStockVdb` in a file: in the same order, with the same metadata, and
/// byte-identical after OpenVDB has read and rewritten them.
void ExpectStockGrids(const std::string& file, const std::string& stock_file) {
  const openvdb::GridPtrVec grids = ReadGrids(file);
  const openvdb::GridPtrVec stock = ReadGrids(stock_file);
  ASSERT_EQ(grids.size(), stock.size());
  for (std::size_t i = 0; i < grids.size(); ++i) {
    SCOPED_TRACE(stock[i]->getName());
    EXPECT_EQ(grids[i]->getName(), stock[i]->getName());
    EXPECT_TRUE(static_cast<const openvdb::MetaMap&>(*grids[i]) ==
                static_cast<const openvdb::MetaMap&>(*stock[i]))
        << grids[i]->str() << "and\n"
        << stock[i]->str();
  }
  EXPECT_TRUE(WriteStockVdb(grids) == stock_file);
}

TEST(VdbEncoder, WritesWhatOpenVdbWrites) {
  for (const MapSnapshot& map : {RandomMap(), BoxOverFloor(), MapSnapshot()}) {
    ExpectStockGrids(*WriteVdb(map, nullptr), WriteStockVdb(map, ShownVolumes(map), nullptr));
  }
}

TEST(VdbEncoder, WritesOfABoxWhatOpenVdbWrites) {
  const MapSnapshot map = RandomMap();
  const MapSnapshot box_over_floor = BoxOverFloor();
  const Box whole_voxels(Eigen::Vector3d(-0.1, -0.1, -0.1), Eigen::Vector3d(0.5, 0.5, 0.5));
  const Box one_object(Eigen::Vector3d(0.5, -2.5, 2.5), Eigen::Vector3d(1.5, -1.5, 3.3));
  const Box nothing(Eigen::Vector3d(-7, -7, -7), Eigen::Vector3d(-6.99, -6.99, -6.99));
  for (const Box& box : {whole_voxels, one_object, nothing}) {
    ExpectStockGrids(*WriteVdb(map, &box), WriteStockVdb(map, ShownVolumes(map), &box));
    ExpectStockGrids(*WriteVdb(box_over_floor, &box),
                     WriteStockVdb(box_over_floor, ShownVolumes(box_over_floor), &box));
  }
}

TEST(VdbEncoder, MakesPiecesOfBoundedLengthThatAddUpToTheFile) {
  const MapSnapshot map = ManyObjects();
  const auto encoder = MakeVdbEncoder(map, ShownVolumes(map), std::nullopt);
  std::vector<std::size_t> lengths;
  std::string file;
  for (std::string piece = "old"; *encoder->Next(&piece); file += piece) {
    lengths.push_back(piece.size());
    ASSERT_FALSE(piece.empty());
    ASSERT_LE(piece.size(), kFilePieceBytes);
  }
  EXPECT_GT(lengths.size(), 3U);
  EXPECT_GT(lengths.front(), kFilePieceBytes / 2) << "pieces are about as long as they may be";
  ExpectStockGrids(file, WriteStockVdb(map, ShownVolumes(map), nullptr));
  std::string piece = "old";
  EXPECT_FALSE(*encoder->Next(&piece)) << "the end stays the end";
  EXPECT_EQ(piece, "");
}

/// Expects that a grid has the values of the leaves of its volume, and no other values.
template <typename Grid, typename ValueOf>
void ExpectVoxels(const PlacedVolume& volume,
                  const openvdb::GridBase::Ptr& grid,
                  const ValueOf& value_of) {
  const auto typed = openvdb::gridPtrCast<Grid>(grid);
  ASSERT_NE(typed, nullptr);
  const auto values = typed->getConstAccessor();
  std::size_t expected = 0;
  volume.voxels->ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    for (int i = 0; i < 512; ++i) {
      if (!IsSet(leaf.observed, static_cast<std::size_t>(i))) continue;
      const auto truth = value_of(leaf, i);
      if (!truth) continue;
      ++expected;
      typename Grid::ValueType found;
      ASSERT_TRUE(
          values.probeValue({origin.x + i / 64, origin.y + i / 8 % 8, origin.z + i % 8}, found));
      ASSERT_EQ(found, *truth);
    }
  });
  EXPECT_EQ(typed->activeVoxelCount(), expected);
}

TEST(VdbEncoder, IsReadFromDiskWithTheVoxelsOfTheMap) {
  const MapSnapshot map = RandomMap();
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Write("map.vdb", *WriteVdb(map, nullptr));

  openvdb::initialize();
  openvdb::io::File file(path.string());
  file.open(/*delayLoad=*/true);
  std::map<std::string, openvdb::GridBase::Ptr> grids;
  for (const openvdb::GridBase::Ptr& grid : *file.getGrids()) grids[grid->getName()] = grid;
  EXPECT_EQ(grids.size(), 12U) << "five volumes, two of them coloured";
  for (const PlacedVolume& volume : ShownVolumes(map)) {
    const std::string name =
        volume.object == nullptr ? "background" : "object-" + std::to_string(volume.id().value());
    SCOPED_TRACE(name);
    ExpectVoxels<openvdb::FloatGrid>(
        volume, grids.at(name + "/distance"), [&map](const LeafView& leaf, int i) {
          return std::optional<float>(map.scale.distance_m(leaf.voxels[i]));
        });
    ExpectVoxels<openvdb::FloatGrid>(
        volume, grids.at(name + "/weight"), [](const LeafView& leaf, int i) {
          return std::optional<float>(leaf.voxels[i].weight());
        });
    if (!grids.contains(name + "/color")) continue;
    ExpectVoxels<openvdb::Vec3fGrid>(
        volume, grids.at(name + "/color"), [](const LeafView& leaf, int i) {
          const std::uint32_t color = leaf.color[i];
          const auto channel = [color](int shift) {
            return static_cast<float>(color >> shift & 0xFFU) / 255.0F;
          };
          return color >> 24 == 0
                     ? std::nullopt
                     : std::optional(openvdb::Vec3f(channel(0), channel(8), channel(16)));
        });
  }
}

TEST(VdbEncoder, StopsWhereItIsCancelled) {
  const MapSnapshot map = ManyObjects();
  const std::string whole = *WriteVdb(map, nullptr);
  bool cancelled = false;
  int asked_in_vain = 0;
  const Cancellation cancellation([&cancelled, &asked_in_vain] {
    if (cancelled) ++asked_in_vain;
    return cancelled;
  });
  const auto encoder = MakeVdbEncoder(map, ShownVolumes(map), std::nullopt, cancellation);
  std::string piece;
  ASSERT_TRUE(*encoder->Next(&piece));
  cancelled = true;
  const absl::StatusOr<bool> next = encoder->Next(&piece);
  EXPECT_EQ(next.status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(piece, "");
  EXPECT_EQ(asked_in_vain, 1) << "it stops at the first leaf, not at the volume's last";
}

TEST(VdbEncoder, CanBeCancelledBeforeItsFirstPiece) {
  const MapSnapshot map = RandomMap();
  const Box everywhere(Eigen::Vector3d::Constant(-1e6), Eigen::Vector3d::Constant(1e6));
  for (const int leaves : {0, 1, 20}) {
    int asked = 0;
    const Cancellation cancellation([&asked, leaves] { return asked++ >= leaves; });
    const auto encoder = MakeVdbEncoder(map, ShownVolumes(map), everywhere, cancellation);
    std::string piece;
    EXPECT_EQ(encoder->Next(&piece).status().code(), absl::StatusCode::kCancelled);
    EXPECT_EQ(asked, leaves + 1);
  }
}

}  // namespace
}  // namespace steadymap
