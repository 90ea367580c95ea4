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
    "`lost` if its frames then contradict the map; such frames are ignored. The offset is the\n"
    "error of the poses of its last session, which the map has corrected, with one standard\n"
    "deviation: by how much known objects were off for the robot. Two sensors contradict each\n"
    "other about objects that one of them sees and the other one finds gone, again and again.\n"
    "Only maps of the pocd policy know robots.\n\n"
    "JSON: {\"revision\", \"robots\": [{\"robot\", \"sensor\", \"trust\", \"last_capture_time\",\n"
    "\"position\" [x, y, z] and \"orientation\" [x, y, z, w] of the camera, \"session_start\" if\n"
    "a session is open, \"offset\" if known: {\"time\", \"center\", \"shift\", \"yaw\",\n"
    "\"covariance\" of shift and yaw (16 numbers, row by row), \"anchors\", the number of known\n"
    "objects that agree}, \"contradictions\": [{\"robot\", \"sensor\", \"objects\" (their\n"
    "number), \"since\"}]}]}. Lengths are metres in the world frame, angles radians, times\n"
    "seconds since 1970.";

constexpr int kCovarianceRows = 4;

/// Returns the standard deviation of entry `i` of an offset; 0 without a covariance.
double SigmaOf(const v1::PoseOffset& offset, int i) {
  const int place = i * (kCovarianceRows + 1);
  return place < offset.covariance_size() ? std::sqrt(offset.covariance(place)) : 0.0;
}

std::string TripleText(double x, double y, double z) {
  return absl::StrCat("(", FixedText(x, 3), ", ", FixedText(y, 3), ", ", FixedText(z, 3), ") m");
}

std::string DegreesText(double angle_rad) {
  return absl::StrCat(FixedText(angle_rad * 180.0 / std::numbers::pi, 2), " degrees");
}

std::string OffsetText(const v1::PoseOffset& offset) {
  const v1::Vector3& shift = offset.shift_m();
  return absl::StrCat("offset ",
                      TripleText(shift.x(), shift.y(), shift.z()),
                      ", ",
                      DegreesText(offset.yaw_rad()),
                      " +- ",
                      TripleText(SigmaOf(offset, 0), SigmaOf(offset, 1), SigmaOf(offset, 2)),
                      ", ",
                      DegreesText(SigmaOf(offset, 3)),
                      ", by ",
                      offset.anchors(),
                      offset.anchors() == 1 ? " object" : " objects");
}

Json OffsetJson(const v1::PoseOffset& offset) {
  Json covariance = Json::array();
  for (const double number : offset.covariance()) covariance.push_back(number);
  return {{"time", SecondsOf(offset.time())},
          {"center", PointJson(offset.center_m())},
          {"shift", PointJson(offset.shift_m())},
          {"yaw", offset.yaw_rad()},
          {"covariance", std::move(covariance)},
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
