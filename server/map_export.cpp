#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "core/error.h"
#include "core/map_mesh.h"
#include "core/mesh_file.h"
#include "core/vdb_file.h"
#include "server/query_answers.h"
#include "server/query_selection.h"

namespace steadymap {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

struct ExportFile {
  std::string bytes;
  std::uint64_t triangles = 0;
};

class ExportChunks final : public MessageSource<v1::ExportMapResponse> {
 public:
  ExportChunks(Revision revision, ExportFile file) : revision_(revision), file_(std::move(file)) {}

  absl::StatusOr<bool> Next(v1::ExportMapResponse* message) override {
    if (!header_sent_) {
      header_sent_ = true;
      v1::ExportMapResponse::Header* header = message->mutable_header();
      header->set_revision(revision_.value());
      header->set_file_bytes(file_.bytes.size());
      header->set_triangles(file_.triangles);
      return true;
    }
    if (next_ == file_.bytes.size()) return false;
    const std::size_t bytes = std::min(kChunkBytes, file_.bytes.size() - next_);
    message->set_chunk(file_.bytes.substr(next_, bytes));
    next_ += bytes;
    return true;
  }

 private:
  const Revision revision_;
  const ExportFile file_;
  bool header_sent_ = false;
  std::size_t next_ = 0;
};

absl::StatusOr<ExportFile> MakeFile(const MapSnapshot& snapshot,
                                    std::span<const PlacedVolume> volumes,
                                    v1::ExportFormat format,
                                    const Box* box) {
  if (format == v1::EXPORT_FORMAT_VDB) {
    absl::StatusOr<std::string> bytes = WriteVdb(snapshot, volumes, box);
    if (!bytes.ok()) return bytes.status();
    return ExportFile{*std::move(bytes), 0};
  }
  const Mesh mesh = ExtractMapMesh(volumes, snapshot.scale, box);
  if (format == v1::EXPORT_FORMAT_PLY) return ExportFile{EncodePly(mesh), mesh.triangles.size()};
  absl::StatusOr<std::string> bytes = EncodeGlb(mesh);
  if (!bytes.ok()) return bytes.status();
  return ExportFile{*std::move(bytes), mesh.triangles.size()};
}

}  // namespace

absl::StatusOr<std::unique_ptr<MessageSource<v1::ExportMapResponse>>> OpenExport(
    const MapSnapshot& snapshot, const v1::ExportMapRequest& request) {
  if (!v1::ExportFormat_IsValid(request.format()) ||
      request.format() == v1::EXPORT_FORMAT_UNSPECIFIED) {
    return InvalidField(reason::kBadValue,
                        "format",
                        absl::StrCat("the format must be one that is known, got ",
                                     static_cast<int>(request.format())));
  }
  const absl::StatusOr<std::optional<Box>> box =
      ReadBox(request.has_box() ? &request.box() : nullptr);
  if (!box.ok()) return box.status();
  const absl::StatusOr<std::vector<PlacedVolume>> volumes =
      SelectVolumes(snapshot, request.object_ids());
  if (!volumes.ok()) return volumes.status();
  absl::StatusOr<ExportFile> file =
      MakeFile(snapshot, *volumes, request.format(), *box ? &**box : nullptr);
  if (!file.ok()) return file.status();
  return std::make_unique<ExportChunks>(snapshot.revision, *std::move(file));
}

}  // namespace steadymap
