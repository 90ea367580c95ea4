#include "client/cli/query/export_command.h"

#include <map>

#include <CLI/CLI.hpp>

#include "client/cli/text/argument_text.h"
#include "client/cli/text/number_text.h"
#include "client/cli/text/output_file.h"
#include "client/map/map_client.h"

namespace steadymap {
namespace {

constexpr char kExportFooter[] =
    "  ply  triangles with normals, and colours where known; metres, map frame, z up\n"
    "  glb  the same triangles as binary glTF 2.0, rotated so that y is up, for viewers\n"
    "  vdb  OpenVDB volumes of signed distance and weight\n\n"
    "The file is written under a temporary name in the same folder, and renamed when it is\n"
    "complete. --box exports only the part of the map between two corners (world frame,\n"
    "metres).\n\n"
    "Without --object, the file contains the background and all present objects. --object 0 is\n"
    "the background; archived objects can be selected too. A vdb file has separate grids for\n"
    "each object, with its class, its state and its pose.";

const std::map<std::string, v1::ExportFormat>& Formats() {
  static const auto* const formats =
      new std::map<std::string, v1::ExportFormat>{{"ply", v1::EXPORT_FORMAT_PLY},
                                                  {"vdb", v1::EXPORT_FORMAT_VDB},
                                                  {"glb", v1::EXPORT_FORMAT_GLB}};
  return *formats;
}

}  // namespace

ExportCommand::ExportCommand(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const command = app->add_subcommand("export", "Write a map to a file");
  command->footer(kExportFooter);
  command->add_option("NAME", map_, "The map")->required();
  command->add_option("--format", format_, "Format of the file, and its extension")
      ->required()
      ->check(CLI::IsMember({"ply", "vdb", "glb"}));
  command->add_option("--output", output_, "The file to write")->required()->type_name("FILE");
  command->add_option("--box", box_, "Only this part of the map")->type_name("x0,y0,z0,x1,y1,z1");
  command->add_option("--object", objects_, "Only this object; may be given several times")
      ->check(CLI::NonNegativeNumber)
      ->allow_extra_args(false)
      ->type_name("ID");
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status ExportCommand::Run() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(map_);
  if (!name.ok()) return name.status();
  if (absl::Status status = CheckEnding(output_, "." + format_); !status.ok()) return status;
  VolumeSelection selection;
  if (!box_.empty()) {
    const absl::StatusOr<Box> parsed = ParseBox(box_);
    if (!parsed.ok()) return parsed.status();
    selection.box_world = *parsed;
  }
  selection.objects.reserve(objects_.size());
  for (const std::uint64_t object : objects_) selection.objects.emplace_back(object);
  absl::StatusOr<OutputFile> file = OutputFile::Create(output_);
  if (!file.ok()) return file.status();
  const absl::StatusOr<ExportSummary> summary =
      MapClient(context_->Channel())
          .ExportMap(*name, Formats().at(format_), selection, [&](std::string_view chunk) {
            return file->Write(chunk);
          });
  if (!summary.ok()) return summary.status();
  absl::Status status = file->Sync();
  if (status.ok()) status = file->Commit();
  if (!status.ok()) return status;
  context_->out << output_ << ": " << BytesText(summary->file_bytes);
  if (summary->triangles > 0) {
    context_->out << ", " << CountText(summary->triangles) << " triangles";
  }
  context_->out << ", revision " << summary->revision.value() << " of " << name->ToString() << '\n';
  return absl::OkStatus();
}

}  // namespace steadymap
