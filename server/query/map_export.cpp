#include "server/query/map_export.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "core/query/file_encoder.h"
#include "core/query/map_mesh.h"
#include "core/query/mesh_file.h"
#include "core/query/mesh_file_glb.h"
#include "core/query/vdb_file.h"
#include "core/types/crc32c.h"
#include "core/types/error.h"
#include "server/query/query_selection.h"

namespace steadymap {
namespace {

/// The file of an export.
struct ExportFile {
  std::unique_ptr<FileEncoder> encoder;
  std::uint64_t triangles = 0;
};

class ExportMessages final : public MessageSource<v1::ExportMapResponse> {
 public:
  /// `file` may refer to data of the snapshot.
  ExportMessages(std::shared_ptr<const MapSnapshot> snapshot, ExportFile file)
      : snapshot_(std::move(snapshot)), file_(std::move(file)) {}

  absl::StatusOr<bool> Next(v1::ExportMapResponse* message) override {
    switch (part_) {
      case Part::kHeader:
        message->mutable_header()->set_revision(snapshot_->revision.value());
        message->mutable_header()->set_triangles(file_.triangles);
        part_ = Part::kChunks;
        return true;
      case Part::kChunks:
        return NextChunk(message);
      case Part::kEnd:
        break;
    }
    return false;
  }

 private:
  enum class Part { kHeader, kChunks, kEnd };

  /// Fills a message with the next chunk, or with the trailer after the last chunk.
  absl::StatusOr<bool> NextChunk(v1::ExportMapResponse* message) {
    const absl::StatusOr<bool> more = file_.encoder->Next(message->mutable_chunk());
    if (!more.ok()) return more.status();
    if (*more) {
      file_bytes_ += message->chunk().size();
      crc32c_ = ExtendCrc32c(crc32c_, message->chunk());
      return true;
    }
    message->mutable_trailer()->set_file_bytes(file_bytes_);
    message->mutable_trailer()->set_crc32c(crc32c_);
    part_ = Part::kEnd;
    return true;
  }

  const std::shared_ptr<const MapSnapshot> snapshot_;
  const ExportFile file_;
  Part part_ = Part::kHeader;  ///< Next part to send.
  std::uint64_t file_bytes_ = 0;
  std::uint32_t crc32c_ = 0;
};

absl::StatusOr<ExportFile> OpenFile(const MapSnapshot& snapshot,
                                    std::vector<PlacedVolume> volumes,
                                    v1::ExportFormat format,
                                    const std::optional<Box>& box,
                                    const Cancellation& cancellation) {
  if (format == v1::EXPORT_FORMAT_VDB) {
    return ExportFile{MakeVdbEncoder(snapshot, std::move(volumes), box, cancellation)};
  }
  Mesh mesh = ExtractMapMesh(volumes, snapshot.scale, box ? &*box : nullptr, cancellation);
  if (cancellation.IsCancelled()) return CancelledFileError();
  const std::uint64_t triangles = mesh.triangles.size();
  if (format == v1::EXPORT_FORMAT_PLY)
    return ExportFile{MakePlyEncoder(std::move(mesh)), triangles};
  absl::StatusOr<std::unique_ptr<FileEncoder>> encoder = MakeGlbEncoder(std::move(mesh));
  if (!encoder.ok()) return encoder.status();
  return ExportFile{*std::move(encoder), triangles};
}

}  // namespace

absl::StatusOr<std::unique_ptr<MessageSource<v1::ExportMapResponse>>> OpenExport(
    std::shared_ptr<const MapSnapshot> snapshot,
    const v1::ExportMapRequest& request,
    const Cancellation& cancellation) {
  if (!v1::ExportFormat_IsValid(request.format()) ||
      request.format() == v1::EXPORT_FORMAT_UNSPECIFIED) {
    return InvalidField(
        reason::kBadValue,
        "format",
        absl::StrCat("the format must be a known value, got ", static_cast<int>(request.format())));
  }
  const absl::StatusOr<std::optional<Box>> box =
      ReadBox(request.has_box() ? &request.box() : nullptr);
  if (!box.ok()) return box.status();
  absl::StatusOr<std::vector<PlacedVolume>> volumes =
      SelectVolumes(*snapshot, request.object_ids());
  if (!volumes.ok()) return volumes.status();
  absl::StatusOr<ExportFile> file =
      OpenFile(*snapshot, *std::move(volumes), request.format(), *box, cancellation);
  if (!file.ok()) return file.status();
  return std::make_unique<ExportMessages>(std::move(snapshot), *std::move(file));
}

}  // namespace steadymap
