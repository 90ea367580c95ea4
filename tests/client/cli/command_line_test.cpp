#include "client/cli/command_line.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "core/types/policy_parameters.h"
#include "tests/client/cli/command_line_fixture.h"

namespace steadymap {
namespace {

TEST_F(CommandLineTest, HelpAndVersionSucceedAndGoToStandardOutput) {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"--help"},
                                             {"--version"},
                                             {"map", "create", "--help"},
                                             {"upload", "--help"},
                                             {"simulate", "--help"},
                                             {"export", "--help"},
                                             {"query", "--help"},
                                             {"render", "--help"}}) {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_NE(outcome.out, "");
    EXPECT_EQ(outcome.err, "");
  }
}

TEST_F(CommandLineTest, MisuseIsOneLineAndExitCodeTwo) {
  ExpectFailure({}, 2, "steadymap --help");
  ExpectFailure({"frobnicate"}, 2, "\"frobnicate\"");
  ExpectFailure({"map", "frobnicate"}, 2, "\"frobnicate\"");
  ExpectFailure({"map", "get"}, 2, "NAME");
  ExpectFailure({"map", "get", "a", "b"}, 2, "b");
  ExpectFailure({"upload", "k", "--format", "kitti", "p"}, 2, "torwic,seven-scenes,tum");
  ExpectFailure({"upload", "k", "p"}, 2, "--format");
  ExpectFailure({"upload", "k", "--format", "tum"}, 2, "PATH");
  ExpectFailure({"upload", "k", "--format", "tum", "p", "--stride", "0"}, 2, "--stride");
  ExpectFailure({"export", "k", "--format", "obj", "--output", "x"}, 2, "ply,vdb,glb");
  ExpectFailure({"query", "k"}, 2, "--point");
  ExpectFailure({"--server", "here", "map", "list"}, 2, "HOST:PORT");
  ExpectFailure({"map", "create", "k", "--voxel-size", "tiny"}, 2, "--voxel-size");
  ExpectFailure({"simulate", "k", "--write", "d", "--route", "twin"}, 2, "--write");
}

TEST_F(CommandLineTest, ServerIsTakenBeforeAndAfterTheCommand) {
  Run({"map", "list"});
  EXPECT_EQ(server_asked_, "localhost:7443");
  Run({"--server", "hall:1", "map", "list"});
  EXPECT_EQ(server_asked_, "hall:1");
  Run({"map", "list", "--server", "hall:2"});
  EXPECT_EQ(server_asked_, "hall:2");
}

TEST_F(CommandLineTest, MapCreateSendsTheContractsDefaults) {
  const Outcome outcome = Run({"map", "create", "kitchen"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const v1::MapConfig& config = maps_.maps.at("tenants/default/maps/kitchen").config();
  EXPECT_EQ(config.voxel_size_m(), 0.05);
  EXPECT_EQ(config.truncation_m(), 0.15);
  EXPECT_EQ(config.max_depth_m(), 3.0);
  EXPECT_EQ(config.policy(), v1::UPDATE_POLICY_STATIC);
  EXPECT_EQ(config.classes_size(), 16);
}

TEST_F(CommandLineTest, MapCreateSendsWhatIsAskedFor) {
  std::ofstream(PathOf("classes.txt")) << "0 floor\n1 person dynamic\n";
  const Outcome outcome = Run({"map",
                               "create",
                               "tenants/acme/maps/hall",
                               "--voxel-size",
                               "0.02",
                               "--truncation",
                               "0.08",
                               "--policy",
                               "pocd",
                               "--classes",
                               PathOf("classes.txt"),
                               "--max-depth",
                               "5"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const v1::MapConfig& config = maps_.maps.at("tenants/acme/maps/hall").config();
  EXPECT_EQ(config.voxel_size_m(), 0.02);
  EXPECT_EQ(config.truncation_m(), 0.08);
  EXPECT_EQ(config.max_depth_m(), 5.0);
  EXPECT_EQ(config.policy(), v1::UPDATE_POLICY_POCD);
  ASSERT_EQ(config.classes_size(), 2);
  EXPECT_EQ(config.classes(1).motion(), v1::CLASS_MOTION_DYNAMIC);
}

TEST_F(CommandLineTest, MapCreateSendsParametersAndPresets) {
  EXPECT_EQ(
      Run({"map", "create", "toys", "--policy", "pocd_paper", "--preset", "table-top"}).exit_code,
      0);
  const v1::MapConfig& toys = maps_.maps.at("tenants/default/maps/toys").config();
  EXPECT_EQ(toys.voxel_size_m(), 0.02);
  EXPECT_EQ(toys.truncation_m(), 0.06);
  EXPECT_EQ(toys.max_depth_m(), 4.0);
  EXPECT_EQ(toys.parameters().at("change_noise_m"), 0.03);
  EXPECT_EQ(toys.parameters().at("max_change_m"), 0.6);
  EXPECT_EQ(toys.parameters().at("min_stationarity"), 0.45);
  EXPECT_EQ(toys.parameters().at("change_scale"), 1.8);
  // Other options override a preset, and other policies take its scale alone.
  EXPECT_EQ(Run({"map",
                 "create",
                 "desk",
                 "--policy",
                 "pocd",
                 "--preset",
                 "office",
                 "--voxel-size",
                 "0.01",
                 "--set",
                 "change_noise_m=0.05",
                 "max_evidence=30"})
                .exit_code,
            0);
  const v1::MapConfig& desk = maps_.maps.at("tenants/default/maps/desk").config();
  EXPECT_EQ(desk.voxel_size_m(), 0.01);
  EXPECT_EQ(desk.parameters().at("change_noise_m"), 0.05);
  EXPECT_EQ(desk.parameters().at("max_evidence"), 30.0);
  EXPECT_EQ(Run({"map", "create", "yard", "--preset", "table-top"}).exit_code, 0);
  EXPECT_EQ(maps_.maps.at("tenants/default/maps/yard").config().parameters_size(), 0);
}

TEST_F(CommandLineTest, MapCreateHelpListsTheParametersOfEachPolicy) {
  const Outcome outcome = Run({"map", "create", "--help"});
  for (const UpdatePolicy policy : {UpdatePolicy::kPocd,
                                    UpdatePolicy::kPocdPaper,
                                    UpdatePolicy::kVoxelChange,
                                    UpdatePolicy::kSubmapChange,
                                    UpdatePolicy::kTracking}) {
    for (const PolicyParameter& parameter : ParametersOf(policy)) {
      EXPECT_NE(outcome.out.find("\n  " + std::string(parameter.name) + " "), std::string::npos)
          << parameter.name;
    }
  }
}

TEST_F(CommandLineTest, TheDefaultTruncationIsThreeVoxels) {
  EXPECT_EQ(Run({"map", "create", "coarse", "--voxel-size", "0.2"}).exit_code, 0);
  EXPECT_DOUBLE_EQ(maps_.maps.at("tenants/default/maps/coarse").config().truncation_m(), 0.6);
  EXPECT_EQ(Run({"map", "create", "fine", "--voxel-size", "0.01"}).exit_code, 0);
  EXPECT_EQ(maps_.maps.at("tenants/default/maps/fine").config().truncation_m(), 0.03);
}

TEST_F(CommandLineTest, MapCreateRefusesWhatNoMapCanHave) {
  ExpectFailure({"map", "create", "k", "--voxel-size", "0"}, 1, "voxel_size_m");
  ExpectFailure({"map", "create", "k", "--voxel-size", "-0.02"}, 1, "[0.001, 1]");
  ExpectFailure({"map", "create", "k", "--voxel-size", "nan"}, 1, "voxel_size_m");
  ExpectFailure({"map", "create", "k", "--truncation", "0"}, 1, "truncation_m");
  ExpectFailure({"map", "create", "k", "--max-depth", "0"}, 1, "max_depth_m");
  ExpectFailure({"map", "create", "k", "--policy", "magic"}, 1, "\"magic\"");
  ExpectFailure({"map", "create", "k", "--preset", "moon"}, 1, "\"moon\"");
  ExpectFailure({"map", "create", "k", "--set", "max_evidence=30"}, 1, "which has: none");
  ExpectFailure({"map", "create", "k", "--policy", "pocd", "--set", "speed"}, 1, "NAME=VALUE");
  ExpectFailure({"map", "create", "k", "--policy", "pocd", "--set", "max_evidence=1"}, 1, "[2.1");
  ExpectFailure({"map", "create", "k", "--classes", PathOf("missing")}, 1, "missing");
  ExpectFailure({"map", "create", "Kitchen"}, 1, "\"Kitchen\"");
  EXPECT_TRUE(maps_.maps.empty());
}

TEST_F(CommandLineTest, ObjectsAndEventsSendTheirFilters) {
  ASSERT_EQ(Run({"map", "create", "kitchen"}).exit_code, 0);
  Outcome outcome = Run({"objects",
                         "kitchen",
                         "--class",
                         "goods materials",
                         "--class",
                         "9",
                         "--box",
                         "0,0,0,1,2,3",
                         "--min-stationarity",
                         "0.5",
                         "--changed-since",
                         "4",
                         "--all",
                         "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.Document(), Json::parse(R"({"revision": 12, "objects": []})"));
  const v1::ListObjectsRequest& objects = queries_.objects_request;
  ASSERT_EQ(objects.class_ids_size(), 2);
  EXPECT_EQ(objects.class_ids(0), 7U);
  EXPECT_EQ(objects.class_ids(1), 9U);
  EXPECT_EQ(objects.box().max_m().z(), 3.0);
  EXPECT_EQ(objects.min_stationarity(), 0.5);
  EXPECT_EQ(objects.changed_since(), 4U);
  EXPECT_TRUE(objects.include_archived());

  outcome = Run({"events",
                 "kitchen",
                 "--type",
                 "moved",
                 "--object",
                 "3",
                 "--since",
                 "1714564800.5",
                 "--until",
                 "2024-05-01T12:00:01Z",
                 "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.Document(), Json::parse(R"({"revision": 12, "events": []})"));
  EXPECT_EQ(queries_.events_request.types(0), v1::EVENT_TYPE_MOVED);
  EXPECT_EQ(queries_.events_request.start_time().seconds(), 1'714'564'800);
  EXPECT_EQ(queries_.events_request.start_time().nanos(), 500'000'000);
  EXPECT_EQ(queries_.events_request.end_time().seconds(), 1'714'564'801);
  ExpectFailure({"events", "kitchen", "--since", "yesterday"}, 1, "\"yesterday\"");
  ExpectFailure({"events", "kitchen", "--until", ""}, 1, "\"\"");
  EXPECT_EQ(queries_.events_request.object_ids(0), 3U);
}

TEST_F(CommandLineTest, RobotsAreListedWithTheirOffsets) {
  v1::Robot& robot = queries_.robots.emplace_back();
  robot.set_robot("dolly");
  robot.set_sensor("left");
  robot.set_trust(v1::ROBOT_TRUST_TRUSTED);
  robot.mutable_last_capture_time()->set_seconds(1'714'564'800);
  robot.mutable_world_from_camera()->mutable_orientation()->set_w(1.0);
  v1::PoseOffset& offset = *robot.mutable_pose_offset();
  offset.mutable_time()->set_seconds(1'714'564'700);
  offset.mutable_shift_m()->set_x(0.05);
  offset.set_yaw_rad(0.0175);
  for (int i = 0; i < 16; ++i) offset.add_covariance(i % 5 == 0 ? 1e-4 : 0.0);
  offset.set_anchors(3);
  v1::PoseError& error = *robot.mutable_pose_error();
  error.mutable_shift_m()->set_y(-0.02);
  error.mutable_rotation_rad()->set_x(0.003);
  error.mutable_rotation_rad()->set_z(0.004);
  for (int i = 0; i < 36; ++i) error.add_covariance(i % 7 == 0 ? 4e-6 : 0.0);
  queries_.robots.push_back(robot);
  queries_.robots[1].clear_pose_error();
  queries_.robots[1].set_trust(v1::ROBOT_TRUST_LOST);
  queries_.robots[1].clear_pose_offset();
  queries_.robots[1].mutable_session_start()->set_seconds(1'714'564'790);
  v1::SensorContradiction& other = *queries_.robots[1].add_contradictions();
  other.set_robot("cart");
  other.set_sensor("left");
  other.set_objects(2);
  other.mutable_since()->set_seconds(1'714'564'795);

  EXPECT_EQ(Run({"robots", "kitchen"}).out,
            "dolly/left  trusted, last frame 2024-05-01T12:00:00Z, pose error (0.000, -0.020, "
            "0.000) m, 0.29 degrees +- (0.002, 0.002, 0.002) m, 0.20 degrees, "
            "offset (0.050, 0.000, 0.000) m, "
            "1.00 degrees +- (0.010, 0.010, 0.010) m, 0.57 degrees, by 3 objects\n"
            "dolly/left  lost, last frame 2024-05-01T12:00:00Z, session since "
            "2024-05-01T11:59:50Z, contradicts cart/left about 2 objects since "
            "2024-05-01T11:59:55Z\n");
  const Json document = Run({"robots", "kitchen", "--json"}).Document();
  EXPECT_EQ(document.at("revision"), 12);
  EXPECT_EQ(document.at("robots").at(0).at("offset").at("shift").at(0), 0.05);
  EXPECT_EQ(document.at("robots").at(0).at("offset").at("covariance").size(), 16U);
  EXPECT_EQ(document.at("robots").at(0).at("pose_error").at("rotation").at(2), 0.004);
  EXPECT_EQ(document.at("robots").at(0).at("pose_error").at("covariance").size(), 36U);
  EXPECT_FALSE(document.at("robots").at(1).contains("pose_error"));
  EXPECT_EQ(document.at("robots").at(0).at("orientation").at(3), 1.0);
  EXPECT_FALSE(document.at("robots").at(1).contains("offset"));
  EXPECT_EQ(document.at("robots").at(1).at("session_start"), 1'714'564'790.0);
  EXPECT_TRUE(document.at("robots").at(0).at("contradictions").empty());
  EXPECT_EQ(document.at("robots").at(1).at("contradictions").at(0).at("objects"), 2);
  ExpectFailure({"robots", "nowhere"}, 1, "NOT_FOUND");
}

TEST_F(CommandLineTest, FiltersThatMakeNoSenseAreErrorsOfOneLine) {
  ASSERT_EQ(Run({"map", "create", "kitchen"}).exit_code, 0);
  ExpectFailure({"objects", "kitchen", "--class", "dragon"}, 1, "\"dragon\"");
  ExpectFailure({"objects", "kitchen", "--box", "1,2,3"}, 1, "a box");
  ExpectFailure({"objects", "kitchen", "--min-stationarity", "2"}, 2, "--min-stationarity");
  ExpectFailure({"objects", "kitchen", "--changed-since", "-1"}, 2, "--changed-since");
  ExpectFailure({"events", "kitchen", "--type", "exploded"}, 1, "created, updated");
  ExpectFailure({"events", "kitchen", "--object", "x"}, 2, "--object");
  ExpectFailure({"objects", "nowhere"}, 1, "NOT_FOUND");
}

TEST_F(CommandLineTest, AnExistingMapAndAnUnknownOneAreErrorsOfOneLine) {
  ASSERT_EQ(Run({"map", "create", "kitchen"}).exit_code, 0);
  ExpectFailure({"map", "create", "kitchen"}, 1, "ALREADY_EXISTS");
  ExpectFailure({"map", "get", "hall"}, 1, "there is no map tenants/default/maps/hall");
  ExpectFailure({"map", "delete", "hall"}, 1, "NOT_FOUND");
}

TEST_F(CommandLineTest, ListingsComeAsTextAndAsJson) {
  for (const char* name : {"attic", "hall", "kitchen"}) Run({"map", "create", name});
  const Outcome text = Run({"map", "list"});
  EXPECT_EQ(std::count(text.out.begin(), text.out.end(), '\n'), 4) << text.out;
  const Json maps = Run({"map", "list", "--json"}).Document().at("maps");
  ASSERT_EQ(maps.size(), 3U) << maps;
  EXPECT_EQ(maps[2].at("name"), "tenants/default/maps/kitchen");
  EXPECT_EQ(maps[2].at("config").at("voxel_size_m"), 0.05);
  EXPECT_EQ(Run({"map", "list", "--tenant", "acme", "--json"}).Document(),
            Json::parse(R"({"maps": []})"));
  const Json one = Run({"map", "get", "hall", "--json"}).Document();
  EXPECT_EQ(one.begin().key(), "name");
  EXPECT_EQ(one.at("name"), "tenants/default/maps/hall");
  EXPECT_NE(Run({"map", "get", "hall"}).out.find("voxel size    5 cm"), std::string::npos);
  EXPECT_EQ(Run({"map", "delete", "hall"}).exit_code, 0);
  EXPECT_EQ(maps_.maps.size(), 2U);
}

TEST_F(CommandLineTest, QueryPrintsStatesAndDistances) {
  v1::DistanceSample& known = *queries_.samples.add_samples();
  known.set_state(v1::POINT_STATE_FREE);
  known.set_distance_m(0.0312);
  known.mutable_gradient()->set_x(-1.0);
  known.set_weight(12.5);
  queries_.samples.add_samples()->set_state(v1::POINT_STATE_UNKNOWN);
  queries_.samples.add_samples()->set_state(v1::POINT_STATE_FREE);
  queries_.samples.set_revision(9);
  const std::vector<std::string> arguments = {
      "query", "kitchen", "--point", "1,2,3", "--point", "-1,0,0.5", "--point", "0,0,1"};
  const Outcome text = Run(arguments);
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_EQ(
      text.out,
      "(1.000, 2.000, 3.000)  free  0.0312 m  gradient (-1.00, 0.00, 0.00)  object 0  class 0  "
      "weight 12.50\n(-1.000, 0.000, 0.500)  unknown\n(0.000, 0.000, 1.000)  free\n");
  EXPECT_EQ(queries_.sample_request.points_m(1).x(), -1.0);
  std::vector<std::string> with_json = arguments;
  with_json.emplace_back("--json");
  EXPECT_EQ(Run(with_json).Document(), Json::parse(R"({
    "revision": 9,
    "samples": [
      {"point_m": [1, 2, 3], "state": "free", "distance_m": 0.0312, "gradient": [-1, 0, 0],
       "object_id": 0, "class_id": 0, "weight": 12.5},
      {"point_m": [-1, 0, 0.5], "state": "unknown"},
      {"point_m": [0, 0, 1], "state": "free"}
    ]
  })"));
  ExpectFailure({"query", "kitchen", "--point", "1,2"}, 1, "x,y,z");
}

TEST_F(CommandLineTest, ExportWritesTheWholeFileOrNone) {
  queries_.SetFile({"ply\n", "rest"}, "ply\nrest");
  const std::string path = PathOf("map.ply");
  const Outcome outcome =
      Run({"export", "kitchen", "--format", "ply", "--output", path, "--box", "-1,-2,0,1,2,3"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(std::filesystem::file_size(path), 8U);
  EXPECT_EQ(queries_.export_request.box().min_m().y(), -2.0);

  queries_.SetFile({"ply\n"}, "ply\nrest");
  ExpectFailure(
      {"export", "kitchen", "--format", "ply", "--output", PathOf("cut.ply")}, 1, "8 bytes");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 1);

  ExpectFailure({"export", "kitchen", "--format", "ply", "--output", PathOf("no/map.ply")},
                1,
                "No such file");
  ExpectFailure({"export", "kitchen", "--format", "ply", "--output", path, "--box", "1,1,1,0,0,0"},
                1,
                "lowest");
}

TEST_F(CommandLineTest, FilesOfAnotherEndingAreRefusedBeforeTheServerIsAsked) {
  for (const char* name : {"map.jpg", "map", "map.png.gz", ".png"}) {
    ExpectFailure({"render", "kitchen", "--output", PathOf(name)}, 1, "ends in .png");
  }
  ExpectFailure(
      {"export", "kitchen", "--format", "vdb", "--output", PathOf("map.ply")}, 1, "ends in .vdb");
  ExpectFailure({"export", "kitchen", "--format", "glb", "--output", PathOf("map")}, 1, ".glb");
  std::ofstream(PathOf("file")) << "in the way";
  ExpectFailure({"mirror", "kitchen", "--output", PathOf("file")}, 1, "cannot make the folder");
  ExpectFailure({"evaluate", "--route", "twin", "--pictures", PathOf("file/pictures")},
                1,
                "cannot make the folder");
  EXPECT_EQ(server_asked_, "");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 1);

  queries_.SetFile({"ply\n"}, "ply\n");
  const Outcome outcome =
      Run({"export", "kitchen", "--format", "ply", "--output", PathOf("MAP.PLY")});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST_F(CommandLineTest, RenderOfAnEmptyMapIsAPicture) {
  v1::GetMapSectionResponse& response = queries_.section.emplace_back();
  response.mutable_header()->set_voxel_size_m(0.05);
  response.mutable_header()->set_truncation_m(0.15);
  const Outcome outcome =
      Run({"render", "kitchen", "--output", PathOf("map.png"), "--size", "600"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  std::string magic(4, '\0');
  std::ifstream(PathOf("map.png")).read(magic.data(), 4);
  EXPECT_EQ(magic, "\x89PNG");
}

}  // namespace
}  // namespace steadymap
