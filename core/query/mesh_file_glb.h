#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <absl/status/statusor.h>

#include "core/query/file_encoder.h"
#include "core/volume/mesh.h"

namespace steadymap {

/// A binary glTF 2.0 file: one mesh node whose rotation takes the world's z axis to glTF's y axis;
/// the positions themselves stay in the world frame, metres. One double-sided matt material.
/// Colours become COLOR_0, RGBA in normalized unsigned bytes, linear as glTF wants it. A
/// mesh without triangles gives a valid file with an empty scene.
/// Errors: `OutOfRange` with reason `BAD_VALUE` beyond 4 GiB, the most that the format can hold.
absl::StatusOr<std::unique_ptr<FileEncoder>> MakeGlbEncoder(Mesh mesh);

/// The whole file. Errors: as the encoder's.
absl::StatusOr<std::string> EncodeGlb(Mesh mesh);

/// Bytes of a GLB file's binary part.
std::uint64_t GlbBufferBytes(std::uint64_t vertices, std::uint64_t triangles, bool with_colors);

}  // namespace steadymap
