#pragma once

#include <string>
#include <string_view>

#include <absl/status/status.h>

#include "core/volume/voxel_leaf.h"

/// The packed form of a leaf, the same on disk and on the wire. The packing is lossless and
/// canonical: equal voxels pack to equal bytes.
///
/// Layout of version 2 (version 1 had finer steps), integers little-endian:
///
///     u8   format: bits 0-3 version (2), bit 4 colour present, bit 5 body is a zstd frame
///     ...  body, compressed if bit 5 is set:
///     u64  observed mask, eight words, word x holds bits y * 8 + z
///     u8   low bytes of the distance residuals, one per observed voxel in offset order
///     u8   high bytes of the distance residuals
///     u8   low bytes of the weight residuals
///     u8   high bytes of the weight residuals
///     u8   red, then green, then blue, then count residuals, if colour is present
///
/// A residual is the difference of a value and its prediction, modulo 2^16 (2^8 for colour), with
/// the sign in the lowest bit. Distances are predicted linearly from the observed neighbours of
/// lower index (the Lorenzo predictor if all seven are observed), weights and colours from the
/// previous observed voxel.
namespace steadymap {

/// Packs a leaf. A leaf without observed voxels packs to an empty string, which means "no leaf"
/// everywhere.
std::string PackLeaf(const LeafView& leaf);

/// Unpacks a leaf to `voxels`; an empty string gives a leaf without observed voxels. Treats its
/// input as hostile. Errors: `DataLoss` with reason `CHECKSUM` for data that `PackLeaf` cannot have
/// written.
absl::Status UnpackLeaf(std::string_view packed, LeafVoxels* voxels);

}  // namespace steadymap
