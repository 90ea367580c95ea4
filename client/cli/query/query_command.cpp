#include "client/cli/query/query_command.h"

#include <utility>

#include <CLI/CLI.hpp>
#include <Eigen/Core>

#include "client/cli/text/argument_text.h"
#include "client/cli/text/json_text.h"
#include "client/cli/text/number_text.h"
#include "client/map/map_client.h"

namespace steadymap {
namespace {

constexpr char kQueryFooter[] =
    "Prints the state of each point (world frame, metres): `surface` at a surface or directly\n"
    "behind it, `free` in front of all surfaces or where a camera observed free space,\n"
    "`unknown` elsewhere. Inside the truncation band, also prints the signed distance to the\n"
    "nearest surface (positive in front of it, negative behind it), the gradient (the\n"
    "direction away from the surface), the object (0 is the background), its class, and the\n"
    "weight of the evidence (1 is one observation from 1 m).";

const char* StateText(v1::PointState state) {
  switch (state) {
    case v1::POINT_STATE_FREE:
      return "free";
    case v1::POINT_STATE_SURFACE:
      return "surface";
    default:
      return "unknown";
  }
}

std::string VectorText(double x, double y, double z, int decimals) {
  return "(" + FixedText(x, decimals) + ", " + FixedText(y, decimals) + ", " +
         FixedText(z, decimals) + ")";
}

void WriteSampleText(const Eigen::Vector3d& point,
                     const v1::DistanceSample& sample,
                     std::ostream* out) {
  *out << VectorText(point.x(), point.y(), point.z(), 3) << "  ";
  *out << StateText(sample.state());
  if (!sample.has_distance_m()) {
    *out << '\n';
    return;
  }
  const v1::Vector3& gradient = sample.gradient();
  *out << "  " << FixedText(sample.distance_m(), 4) << " m  gradient "
       << VectorText(gradient.x(), gradient.y(), gradient.z(), 2) << "  object "
       << sample.object_id() << "  class " << sample.class_id() << "  weight "
       << FixedText(sample.weight(), 2) << '\n';
}

Json SampleJson(const Eigen::Vector3d& point, const v1::DistanceSample& sample) {
  Json json = {{"point_m", VectorJson(point.x(), point.y(), point.z())},
               {"state", StateText(sample.state())}};
  if (sample.has_distance_m()) {
    json["distance_m"] = sample.distance_m();
    const v1::Vector3& gradient = sample.gradient();
    json["gradient"] = VectorJson(gradient.x(), gradient.y(), gradient.z());
    json["object_id"] = sample.object_id();
    json["class_id"] = sample.class_id();
    json["weight"] = sample.weight();
  }
  return json;
}

}  // namespace

QueryCommand::QueryCommand(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const command =
      app->add_subcommand("query", "Show the distance of points from the nearest surface");
  command->footer(kQueryFooter);
  command->add_option("NAME", map_, "The map")->required();
  command->add_option("--point", points_, "Point to query; may be given several times")
      ->required()
      ->type_name("x,y,z");
  command->add_flag("--json", as_json_, "Print JSON");
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status QueryCommand::Run() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(map_);
  if (!name.ok()) return name.status();
  std::vector<Eigen::Vector3d> points;
  for (const std::string& text : points_) {
    const absl::StatusOr<Eigen::Vector3d> point = ParsePoint(text);
    if (!point.ok()) return point.status();
    points.push_back(*point);
  }
  const absl::StatusOr<v1::SampleDistanceResponse> answer =
      MapClient(context_->Channel()).SampleDistance(*name, points);
  if (!answer.ok()) return answer.status();
  Json samples = Json::array();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const v1::DistanceSample& sample = answer->samples(static_cast<int>(i));
    if (as_json_) {
      samples.push_back(SampleJson(points[i], sample));
    } else {
      WriteSampleText(points[i], sample, &context_->out);
    }
  }
  if (as_json_) {
    context_->out << IndentedJson(
        {{"revision", answer->revision()}, {"samples", std::move(samples)}});
  }
  return absl::OkStatus();
}

}  // namespace steadymap
