#include "client/cli/query/robots_command.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <CLI/CLI.hpp>
#include <absl/strings/str_cat.h>

#include "client/cli/query/object_text.h"
#include "client/cli/text/argument_text.h"
#include "client/cli/text/enumerator_text.h"
#include "client/cli/text/number_text.h"
#include "client/map/map_client.h"

namespace steadymap {
namespace {

constexpr char kRobotsFooter[] =
    "One line for each sensor of a robot. A robot is `doubted` after a jump of its pose and\n"
    "`lost` if its frames then contradict the map; such frames are ignored. The pose error is\n"
    "the correction of its last used frame, by registration to the map; the offset is that of\n"
    "its last session at its end, by the known objects in place too; each with one standard\n"
    "deviation. The map has applied both. Two sensors contradict each other about objects that\n"
    "one of them sees and the other one finds gone, again and again.\n"
    "Only maps of the pocd policy know robots.\n\n"
    "JSON: {\"revision\", \"robots\": [{\"robot\", \"sensor\", \"trust\", \"last_capture_time\",\n"
    "\"position\" [x, y, z] and \"orientation\" [x, y, z, w] of the camera, \"session_start\" if\n"
    "a session is open, \"pose_error\" if known: {\"time\", \"shift\", \"rotation\" (axis times\n"
    "angle), \"covariance\" of both (36 numbers, row by row)}, \"offset\" if known: {\"time\",\n"
    "\"center\", \"shift\", \"yaw\", \"covariance\" of shift and yaw (16 numbers, row by row),\n"
    "\"anchors\", the number of known objects that agree}, \"contradictions\": [{\"robot\",\n"
    "\"sensor\", \"objects\" (their number), \"since\"}]}]}. Lengths are metres in the world\n"
    "frame, angles radians, times seconds since 1970.";

using Covariance = google::protobuf::RepeatedField<double>;

/// Returns the standard deviation of entry `i` of a covariance with `rows` rows, row by row; 0
/// without a covariance.
double SigmaOf(const Covariance& covariance, int rows, int i) {
  const int place = i * (rows + 1);
  return place < covariance.size() ? std::sqrt(covariance[place]) : 0.0;
}

Json CovarianceJson(const Covariance& covariance) {
  Json numbers = Json::array();
  for (const double number : covariance) numbers.push_back(number);
  return numbers;
}

std::string TripleText(double x, double y, double z) {
  return absl::StrCat("(", FixedText(x, 3), ", ", FixedText(y, 3), ", ", FixedText(z, 3), ") m");
}

std::string DegreesText(double angle_rad) {
  return absl::StrCat(FixedText(angle_rad * 180.0 / std::numbers::pi, 2), " degrees");
}

double NormOf(const v1::Vector3& vector) { return std::hypot(vector.x(), vector.y(), vector.z()); }

std::string ErrorText(const v1::PoseError& error) {
  constexpr int kRows = 6;
  const v1::Vector3& shift = error.shift_m();
  const auto sigma = [&](int i) { return SigmaOf(error.covariance(), kRows, i); };
  return absl::StrCat("pose error ",
                      TripleText(shift.x(), shift.y(), shift.z()),
                      ", ",
                      DegreesText(NormOf(error.rotation_rad())),
                      " +- ",
                      TripleText(sigma(0), sigma(1), sigma(2)),
                      ", ",
                      DegreesText(std::hypot(sigma(3), sigma(4), sigma(5))));
}

Json ErrorJson(const v1::PoseError& error) {
  return {{"time", SecondsOf(error.time())},
          {"shift", PointJson(error.shift_m())},
          {"rotation", PointJson(error.rotation_rad())},
          {"covariance", CovarianceJson(error.covariance())}};
}

std::string OffsetText(const v1::PoseOffset& offset) {
  constexpr int kRows = 4;
  const v1::Vector3& shift = offset.shift_m();
  const auto sigma = [&](int i) { return SigmaOf(offset.covariance(), kRows, i); };
  return absl::StrCat("offset ",
                      TripleText(shift.x(), shift.y(), shift.z()),
                      ", ",
                      DegreesText(offset.yaw_rad()),
                      " +- ",
                      TripleText(sigma(0), sigma(1), sigma(2)),
                      ", ",
                      DegreesText(sigma(3)),
                      ", by ",
                      offset.anchors(),
                      offset.anchors() == 1 ? " object" : " objects");
}

Json OffsetJson(const v1::PoseOffset& offset) {
  return {{"time", SecondsOf(offset.time())},
          {"center", PointJson(offset.center_m())},
          {"shift", PointJson(offset.shift_m())},
          {"yaw", offset.yaw_rad()},
          {"covariance", CovarianceJson(offset.covariance())},
          {"anchors", offset.anchors()}};
}

}  // namespace

std::string RobotText(const v1::Robot& robot) {
  std::string text = absl::StrCat(robot.robot(),
                                  "/",
                                  robot.sensor(),
                                  "  ",
                                  WordOf(v1::RobotTrust_descriptor(), robot.trust()),
                                  ", last frame ",
                                  TimeText(robot.last_capture_time()));
  if (robot.has_session_start()) {
    absl::StrAppend(&text, ", session since ", TimeText(robot.session_start()));
  }
  if (robot.has_pose_error()) absl::StrAppend(&text, ", ", ErrorText(robot.pose_error()));
  if (robot.has_pose_offset()) absl::StrAppend(&text, ", ", OffsetText(robot.pose_offset()));
  for (const v1::SensorContradiction& other : robot.contradictions()) {
    absl::StrAppend(&text,
                    ", contradicts ",
                    other.robot(),
                    "/",
                    other.sensor(),
                    " about ",
                    other.objects(),
                    other.objects() == 1 ? " object" : " objects",
                    " since ",
                    TimeText(other.since()));
  }
  return text;
}

Json RobotJson(const v1::Robot& robot) {
  const v1::Quaternion& turn = robot.world_from_camera().orientation();
  Json json = {{"robot", robot.robot()},
               {"sensor", robot.sensor()},
               {"trust", WordOf(v1::RobotTrust_descriptor(), robot.trust())},
               {"last_capture_time", SecondsOf(robot.last_capture_time())},
               {"position", PointJson(robot.world_from_camera().position_m())},
               {"orientation", Json::array({turn.x(), turn.y(), turn.z(), turn.w()})}};
  if (robot.has_session_start()) json["session_start"] = SecondsOf(robot.session_start());
  if (robot.has_pose_error()) json["pose_error"] = ErrorJson(robot.pose_error());
  if (robot.has_pose_offset()) json["offset"] = OffsetJson(robot.pose_offset());
  json["contradictions"] = Json::array();
  for (const v1::SensorContradiction& other : robot.contradictions()) {
    json["contradictions"].push_back({{"robot", other.robot()},
                                      {"sensor", other.sensor()},
                                      {"objects", other.objects()},
                                      {"since", SecondsOf(other.since())}});
  }
  return json;
}

RobotsCommand::RobotsCommand(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const command = app->add_subcommand("robots", "List the robots that a map knows");
  command->footer(kRobotsFooter);
  command->add_option("NAME", map_, "The map")->required();
  command->add_flag("--json", as_json_, "Print JSON");
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status RobotsCommand::Run() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(map_);
  if (!name.ok()) return name.status();
  MapClient client(context_->Channel());
  const absl::StatusOr<MapList<v1::Robot>> robots = client.ListRobots(*name);
  if (!robots.ok()) return robots.status();
  if (as_json_) {
    Json entries = Json::array();
    for (const v1::Robot& robot : robots->entries) entries.push_back(RobotJson(robot));
    const Json document = {{"revision", robots->revision.value()}, {"robots", std::move(entries)}};
    context_->out << IndentedJson(document);
  } else {
    for (const v1::Robot& robot : robots->entries) context_->out << RobotText(robot) << '\n';
  }
  return absl::OkStatus();
}

}  // namespace steadymap
