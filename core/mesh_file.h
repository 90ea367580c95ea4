#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <absl/status/statusor.h>

#include "core/file_encoder.h"
#include "core/mesh.h"

/// Meshes as files that other tools open. Every mesh must be whole: one normal a vertex, one colour
/// a vertex or none at all, indices below the number of vertices (asserted).
///
/// An encoder keeps the mesh and makes the file from it piece by piece, at the cost of one pass.
namespace steadymap {

/// A PLY file: binary little-endian; vertices with x y z nx ny nz as float and, where the mesh has
/// colours, red green blue as uchar (sRGB); faces as `list uchar int vertex_indices`. Metres, world
/// frame, z up. An empty mesh gives a valid file without vertices.
std::unique_ptr<FileEncoder> MakePlyEncoder(Mesh mesh);

/// A binary glTF 2.0 file: one mesh node whose rotation takes the world's z axis to glTF's y axis;
/// the positions themselves stay in the world frame, metres. One double-sided matt material.
/// Colours become COLOR_0, RGBA in normalized unsigned bytes, linear as glTF wants it. A
/// mesh without triangles gives a valid file with an empty scene.
/// Errors: `OutOfRange` with reason `BAD_VALUE` beyond 4 GiB, the most that the format can hold.
absl::StatusOr<std::unique_ptr<FileEncoder>> MakeGlbEncoder(Mesh mesh);

/// The whole of such files. Errors: as the encoders'.
std::string EncodePly(Mesh mesh);
absl::StatusOr<std::string> EncodeGlb(Mesh mesh);

/// Bytes of a GLB file's binary part.
std::uint64_t GlbBufferBytes(std::uint64_t vertices, std::uint64_t triangles, bool with_colors);

}  // namespace steadymap
