#include "tests/core/volume/random_leaf.h"

#include <cstddef>
#include <cstdint>

namespace steadymap {

LeafVoxels RandomLeaf(std::mt19937* random, double probability, bool smooth, bool color) {
  LeafVoxels leaf;
  leaf.has_color = color;
  std::bernoulli_distribution observed(probability);
  std::uniform_int_distribution<int> wild(-kMaxDistanceSteps, kMaxDistanceSteps);
  std::uniform_int_distribution<int> jitter(-3, 3);
  std::uniform_int_distribution<int> weight(1, 65535);
  for (int x = 0; x < kLeafSide; ++x) {
    for (int y = 0; y < kLeafSide; ++y) {
      for (int z = 0; z < kLeafSide; ++z) {
        if (!observed(*random)) continue;
        const std::size_t offset = OffsetInLeaf(x, y, z);
        leaf.observed[offset >> 6] |= std::uint64_t{1} << (offset & 63);
        const int steps = smooth ? 46 * x - 38 * y + 14 * z - 78 + jitter(*random) : wild(*random);
        leaf.voxels[offset] =
            Voxel(steps, smooth ? 300 + 5 * z + jitter(*random) : weight(*random));
        if (color) leaf.color[offset] = static_cast<std::uint32_t>((*random)());
      }
    }
  }
  return leaf;
}

}  // namespace steadymap
