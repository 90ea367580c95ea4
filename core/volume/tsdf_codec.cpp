#include "core/volume/tsdf_codec.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <vector>

#include <zstd.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr std::uint8_t kVersion = 2;
constexpr std::uint8_t kVersionMask = 0x0F;
constexpr std::uint8_t kColorFlag = 0x10;
constexpr std::uint8_t kZstdFlag = 0x20;
constexpr std::uint8_t kKnownFlags = kVersionMask | kColorFlag | kZstdFlag;

// Level 1 is nearly as effective as higher levels: the residuals are mostly noise.
constexpr int kVolumeZstdLevel = 1;

constexpr std::size_t kMaskBytes = kLeafSide * sizeof(std::uint64_t);
constexpr std::size_t kGeometryBytesPerVoxel = 4;
constexpr std::size_t kColorBytesPerVoxel = 4;
constexpr std::size_t kMaxBodyBytes =
    kMaskBytes + kLeafVoxels * (kGeometryBytesPerVoxel + kColorBytesPerVoxel);

using Steps = std::array<std::int32_t, kLeafVoxels>;

std::uint16_t ToZigzag(std::int32_t residual) {
  const auto wrapped = static_cast<std::int16_t>(static_cast<std::uint16_t>(residual));
  return static_cast<std::uint16_t>((wrapped << 1) ^ (wrapped >> 15));
}

std::int32_t FromZigzag(std::uint16_t zigzag) {
  return (zigzag >> 1) ^ -static_cast<std::int32_t>(zigzag & 1U);
}

std::uint8_t ToZigzag8(std::int32_t residual) {
  const auto wrapped = static_cast<std::int8_t>(static_cast<std::uint8_t>(residual));
  return static_cast<std::uint8_t>((wrapped << 1) ^ (wrapped >> 7));
}

std::int32_t FromZigzag8(std::uint8_t zigzag) {
  return (zigzag >> 1) ^ -static_cast<std::int32_t>(zigzag & 1U);
}

/// Offsets of the lower neighbours along x, y, z.
constexpr std::size_t kX = 64;
constexpr std::size_t kY = 8;
constexpr std::size_t kZ = 1;

/// Predicts a distance from the observed voxels of lower index. For a linear field with all
/// neighbours observed, the prediction is exact.
std::int32_t PredictDistance(const LeafMask& mask, const Steps& steps, std::size_t offset) {
  const bool x = (offset >> 6) > 0;
  const bool y = ((offset >> 3) & 7) > 0;
  const std::size_t z = offset & 7;
  const auto has = [&mask](std::size_t at) { return IsSet(mask, at); };
  if (x && y && z > 0 && has(offset - kX) && has(offset - kY) && has(offset - kZ) &&
      has(offset - kX - kY) && has(offset - kX - kZ) && has(offset - kY - kZ) &&
      has(offset - kX - kY - kZ)) {
    return steps[offset - kX] + steps[offset - kY] + steps[offset - kZ] - steps[offset - kX - kY] -
           steps[offset - kX - kZ] - steps[offset - kY - kZ] + steps[offset - kX - kY - kZ];
  }
  if (z > 0 && y && has(offset - kZ) && has(offset - kY) && has(offset - kY - kZ)) {
    return steps[offset - kZ] + steps[offset - kY] - steps[offset - kY - kZ];
  }
  if (z > 0 && x && has(offset - kZ) && has(offset - kX) && has(offset - kX - kZ)) {
    return steps[offset - kZ] + steps[offset - kX] - steps[offset - kX - kZ];
  }
  if (z > 1 && has(offset - kZ) && has(offset - 2 * kZ)) {
    return 2 * steps[offset - kZ] - steps[offset - 2 * kZ];
  }
  if (z > 0 && has(offset - kZ)) return steps[offset - kZ];
  if (y && has(offset - kY)) return steps[offset - kY];
  if (x && has(offset - kX)) return steps[offset - kX];
  return 0;
}

void WriteGeometry(const LeafView& leaf, std::uint8_t* body) {
  const std::size_t count = CountBits(leaf.observed);
  Steps distance_steps{};
  std::int32_t last_weight = 0;
  std::size_t i = 0;
  ForEachBit(leaf.observed, [&](std::size_t offset) {
    distance_steps[offset] = leaf.voxels[offset].distance_steps();
    const std::uint16_t distance =
        ToZigzag(distance_steps[offset] - PredictDistance(leaf.observed, distance_steps, offset));
    const std::int32_t weight_units = leaf.voxels[offset].weight_units();
    const std::uint16_t weight = ToZigzag(weight_units - last_weight);
    last_weight = weight_units;
    body[i] = static_cast<std::uint8_t>(distance & 0xFF);
    body[count + i] = static_cast<std::uint8_t>(distance >> 8);
    body[2 * count + i] = static_cast<std::uint8_t>(weight & 0xFF);
    body[3 * count + i] = static_cast<std::uint8_t>(weight >> 8);
    ++i;
  });
}

void WriteColor(const LeafView& leaf, std::uint8_t* body) {
  const std::size_t count = CountBits(leaf.observed);
  std::array<std::int32_t, kColorBytesPerVoxel> last{};
  std::size_t i = 0;
  ForEachBit(leaf.observed, [&](std::size_t offset) {
    for (std::size_t channel = 0; channel < kColorBytesPerVoxel; ++channel) {
      const auto value = static_cast<std::int32_t>((leaf.color[offset] >> (8 * channel)) & 0xFFU);
      body[channel * count + i] = ToZigzag8(value - last[channel]);
      last[channel] = value;
    }
    ++i;
  });
}

absl::Status Damaged(std::string_view what) {
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   "a packed leaf is corrupt: " + std::string(what));
}

absl::Status ReadGeometry(const std::uint8_t* body, LeafVoxels* voxels) {
  const std::size_t count = CountBits(voxels->observed);
  Steps distance_steps{};
  std::int32_t last_weight = 0;
  bool in_range = true;
  std::size_t i = 0;
  ForEachBit(voxels->observed, [&](std::size_t offset) {
    const auto distance =
        static_cast<std::uint16_t>(body[i] | static_cast<unsigned>(body[count + i]) << 8);
    const auto weight = static_cast<std::uint16_t>(body[2 * count + i] |
                                                   static_cast<unsigned>(body[3 * count + i]) << 8);
    distance_steps[offset] = static_cast<std::int16_t>(static_cast<std::uint16_t>(
        PredictDistance(voxels->observed, distance_steps, offset) + FromZigzag(distance)));
    last_weight = static_cast<std::uint16_t>(last_weight + FromZigzag(weight));
    in_range = in_range && std::abs(distance_steps[offset]) <= kMaxDistanceSteps && last_weight > 0;
    voxels->voxels[offset] = Voxel(distance_steps[offset], last_weight);
    ++i;
  });
  return in_range ? absl::OkStatus() : Damaged("a voxel value is out of range");
}

void ReadColor(const std::uint8_t* body, LeafVoxels* voxels) {
  const std::size_t count = CountBits(voxels->observed);
  std::array<std::int32_t, kColorBytesPerVoxel> last{};
  std::size_t i = 0;
  ForEachBit(voxels->observed, [&](std::size_t offset) {
    for (std::size_t channel = 0; channel < kColorBytesPerVoxel; ++channel) {
      last[channel] =
          static_cast<std::uint8_t>(last[channel] + FromZigzag8(body[channel * count + i]));
      voxels->color[offset] |= static_cast<std::uint32_t>(last[channel]) << (8 * channel);
    }
    ++i;
  });
}

/// The zstd contexts of a thread. The creation of a context takes longer than the packing of a
/// leaf.
struct ZstdContexts {
  ZSTD_CCtx* compress = ZSTD_createCCtx();
  ZSTD_DCtx* decompress = ZSTD_createDCtx();
  ZstdContexts() = default;
  ZstdContexts(const ZstdContexts&) = delete;
  ZstdContexts& operator=(const ZstdContexts&) = delete;

  ~ZstdContexts() {
    ZSTD_freeCCtx(compress);
    ZSTD_freeDCtx(decompress);
  }
};

ZstdContexts& ThreadContexts() {
  thread_local ZstdContexts contexts;
  return contexts;
}

/// Returns the body of a packed leaf, decompressed into `buffer` if necessary; empty if it is
/// corrupt.
std::string_view BodyOf(std::string_view packed, std::array<char, kMaxBodyBytes>* buffer) {
  const std::string_view stored = packed.substr(1);
  if ((static_cast<std::uint8_t>(packed[0]) & kZstdFlag) == 0) return stored;
  const std::size_t size = ZSTD_decompressDCtx(
      ThreadContexts().decompress, buffer->data(), buffer->size(), stored.data(), stored.size());
  return ZSTD_isError(size) != 0 ? std::string_view() : std::string_view(buffer->data(), size);
}

}  // namespace

std::string PackLeaf(const LeafView& leaf) {
  const std::size_t count = CountBits(leaf.observed);
  if (count == 0) return {};
  const bool has_color = leaf.color != nullptr;
  const std::size_t body_bytes =
      kMaskBytes + count * (kGeometryBytesPerVoxel + (has_color ? kColorBytesPerVoxel : 0));
  std::array<std::uint8_t, kMaxBodyBytes> body;
  std::memcpy(body.data(), leaf.observed.data(), kMaskBytes);
  WriteGeometry(leaf, body.data() + kMaskBytes);
  if (has_color) WriteColor(leaf, body.data() + kMaskBytes + kGeometryBytesPerVoxel * count);

  std::array<char, ZSTD_COMPRESSBOUND(kMaxBodyBytes)> compressed;
  const std::size_t compressed_bytes = ZSTD_compressCCtx(ThreadContexts().compress,
                                                         compressed.data(),
                                                         compressed.size(),
                                                         body.data(),
                                                         body_bytes,
                                                         kVolumeZstdLevel);
  const bool pays = ZSTD_isError(compressed_bytes) == 0 && compressed_bytes < body_bytes;
  std::uint8_t format = kVersion;
  if (has_color) format |= kColorFlag;
  if (pays) format |= kZstdFlag;
  std::string packed(1, static_cast<char>(format));
  if (pays) {
    packed.append(compressed.data(), compressed_bytes);
  } else {
    packed.append(reinterpret_cast<const char*>(body.data()), body_bytes);
  }
  return packed;
}

absl::Status UnpackLeaf(std::string_view packed, LeafVoxels* voxels) {
  *voxels = LeafVoxels{};
  if (packed.empty()) return absl::OkStatus();
  const auto format = static_cast<std::uint8_t>(packed[0]);
  if ((format & kVersionMask) != kVersion || (format & ~kKnownFlags) != 0) {
    return Damaged("unknown format byte");
  }
  std::array<char, kMaxBodyBytes> buffer;
  const std::string_view body = BodyOf(packed, &buffer);
  if (body.size() < kMaskBytes) return Damaged("the body is shorter than the mask");
  std::memcpy(voxels->observed.data(), body.data(), kMaskBytes);
  const std::size_t count = CountBits(voxels->observed);
  voxels->has_color = (format & kColorFlag) != 0;
  const std::size_t bytes_per_voxel =
      kGeometryBytesPerVoxel + (voxels->has_color ? kColorBytesPerVoxel : 0);
  if (count == 0 || body.size() != kMaskBytes + count * bytes_per_voxel) {
    return Damaged("the length of the body does not match the mask");
  }
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(body.data()) + kMaskBytes;
  if (absl::Status status = ReadGeometry(bytes, voxels); !status.ok()) return status;
  if (voxels->has_color) ReadColor(bytes + kGeometryBytesPerVoxel * count, voxels);
  return absl::OkStatus();
}

}  // namespace steadymap
