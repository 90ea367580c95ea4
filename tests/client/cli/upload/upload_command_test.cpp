#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "proto/convert_status.h"
#include "tests/client/cli/command_line_fixture.h"

namespace steadymap {
namespace {

using UploadCommandTest = CommandLineTest;

TEST_F(UploadCommandTest, SimulateCreatesTheMapAndWaitsForIntegration) {
  const Outcome outcome = Run({"simulate",
                               "demo",
                               "--policy",
                               "static",
                               "--route",
                               "twin",
                               "--ideal",
                               "--stride",
                               "40",
                               "--robot",
                               "r2"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(maps_.maps.contains("tenants/default/maps/demo"));
  EXPECT_NE(outcome.err.find("created tenants/default/maps/demo with the policy static, 5 cm"),
            std::string::npos)
      << outcome.err;
  EXPECT_NE(outcome.out.find(" frames integrated in "), std::string::npos);
  EXPECT_NE(outcome.out.find(" 0 refused"), std::string::npos);
}

TEST_F(UploadCommandTest, WhatSimulateWritesUploadReads) {
  const std::string recording = PathOf("recording");
  ASSERT_EQ(Run({"simulate", "--write", recording, "--route", "twin", "--stride", "40"}).exit_code,
            0);
  const Outcome outcome =
      Run({"upload", "demo", "--format", "torwic", recording, "--policy", "pocd", "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.Document().at("refused_count"), 0) << outcome.out;
  EXPECT_GT(outcome.Document().at("integrated"), 0) << outcome.out;
}

TEST_F(UploadCommandTest, UploadErrorsAreOneLineAndUploadNothing) {
  ExpectFailure({"upload", "k", "--format", "tum", PathOf("missing")}, 1, "missing");
  ExpectFailure({"simulate", "k", "--route", "nowhere"}, 1, "\"nowhere\"");
  ExpectFailure({"simulate", "--route", "twin"}, 1, "--write");
  ExpectFailure({"simulate", "k", "--route", "twin", "--robot", "R2"}, 1, "\"R2\"");
  EXPECT_EQ(ingest_.streams_opened(), 0U);
  EXPECT_TRUE(maps_.maps.empty());
}

TEST_F(UploadCommandTest, UploadingToAMapThatIsMissingAsksForItsPolicy) {
  const std::vector<std::string> command = {"simulate", "k", "--route", "twin", "--stride", "40"};
  ExpectFailure(command, 1, "--policy pocd");
  ExpectFailure(command, 1, "steadymap map create k");
  std::vector<std::string> with_voxels = command;
  with_voxels.insert(with_voxels.end(), {"--voxel-size", "0.1"});
  ExpectFailure(with_voxels, 1, "--policy");
  std::vector<std::string> misspelt = command;
  misspelt.insert(misspelt.end(), {"--policy", "magic"});
  ExpectFailure(misspelt, 1, "\"magic\"");
  EXPECT_TRUE(maps_.maps.empty());
  EXPECT_EQ(ingest_.streams_opened(), 0U);
}

TEST_F(UploadCommandTest, UploadCreatesTheMapThatItsOptionsDescribe) {
  std::ofstream(PathOf("classes.txt")) << "1 floor\n2 person dynamic\n40 cart\n";
  const Outcome outcome = Run({"simulate",
                               "k",
                               "--route",
                               "twin",
                               "--stride",
                               "40",
                               "--policy",
                               "voxel_change",
                               "--voxel-size",
                               "0.1",
                               "--truncation",
                               "0.4",
                               "--max-depth",
                               "5",
                               "--classes",
                               PathOf("classes.txt")});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const v1::MapConfig& config = maps_.maps.at("tenants/default/maps/k").config();
  EXPECT_EQ(config.policy(), v1::UPDATE_POLICY_VOXEL_CHANGE);
  EXPECT_EQ(config.voxel_size_m(), 0.1);
  EXPECT_EQ(config.truncation_m(), 0.4);
  EXPECT_EQ(config.max_depth_m(), 5.0);
  EXPECT_EQ(config.classes_size(), 3);
}

TEST_F(UploadCommandTest, OptionsThatAMapContradictsAreAnErrorAndThoseThatItHasAreNot) {
  ASSERT_EQ(Run({"map", "create", "k", "--policy", "pocd", "--voxel-size", "0.1"}).exit_code, 0);
  const auto with = [](const std::vector<std::string>& options) {
    std::vector<std::string> command = {"simulate", "k", "--route", "twin", "--stride", "40"};
    command.insert(command.end(), options.begin(), options.end());
    return command;
  };
  ExpectFailure(with({"--policy", "static"}), 1, "has --policy pocd, not static");
  ExpectFailure(with({"--voxel-size", "0.05"}), 1, "has --voxel-size 10 cm, not 5 cm");
  std::ofstream(PathOf("classes.txt")) << "1 floor\n";
  ExpectFailure(with({"--classes", PathOf("classes.txt")}), 1, "--classes");
  EXPECT_EQ(ingest_.streams_opened(), 0U);
  EXPECT_EQ(Run(with({"--policy", "pocd", "--voxel-size", "0.1"})).exit_code, 0);
}

TEST_F(UploadCommandTest, AMapWhosePolicyOnlyItsServerKnowsTakesFrames) {
  v1::Map& map = maps_.maps["tenants/default/maps/k"];
  map.set_name("tenants/default/maps/k");
  map.mutable_config()->set_policy(static_cast<v1::UpdatePolicy>(99));
  const Outcome outcome = Run({"simulate", "k", "--route", "twin", "--stride", "40"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST_F(UploadCommandTest, AMapOfObjectsThatGetsNoLabelsIsWarnedAboutOnce) {
  const std::string recording = PathOf("recording");
  ASSERT_EQ(Run({"simulate", "--write", recording, "--route", "twin", "--stride", "40"}).exit_code,
            0);
  const auto warnings = [&](const std::string& map, const std::string& policy) {
    const Outcome outcome =
        Run({"upload", map, "--policy", policy, "--format", "torwic", recording});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    std::size_t count = 0;
    for (std::size_t at = 0; (at = outcome.err.find("neither labels nor", at)) != std::string::npos;
         ++at) {
      ++count;
    }
    return count;
  };
  EXPECT_EQ(warnings("labelled", "pocd"), 0U);
  for (const auto& sequence : std::filesystem::directory_iterator(recording)) {
    std::filesystem::remove_all(sequence.path() / "Segmentation");
    std::filesystem::remove_all(sequence.path() / "Instances");
  }
  EXPECT_EQ(warnings("objects", "pocd_paper"), 1U);
  EXPECT_EQ(warnings("objects", "pocd_paper"), 1U);
  EXPECT_EQ(warnings("things", "pocd"), 0U);
  EXPECT_EQ(warnings("surface", "static"), 0U);
}

TEST_F(UploadCommandTest, DepthOfAWrongUnitIsRefusedBeforeAnythingIsUploaded) {
  const std::string recording = PathOf("recording");
  ASSERT_EQ(Run({"simulate", "--write", recording, "--route", "twin", "--stride", "40"}).exit_code,
            0);
  const auto upload = [&](const std::vector<std::string>& options) {
    std::vector<std::string> command = {
        "upload", "k", "--policy", "static", "--format", "torwic", recording};
    command.insert(command.end(), options.begin(), options.end());
    return command;
  };
  ExpectFailure(upload({"--depth-scale", "0.000001"}), 1, "--depth-scale");
  ExpectFailure(upload({"--depth-scale", "0.1"}), 1, "at 0.1 m per unit");
  ExpectFailure(upload({"--depth-scale", "1000"}), 1, "metres per unit in [1e-6, 0.1]");
  ExpectFailure(upload({"--intrinsics", "525,525,320"}), 1, "fx,fy,cx,cy");
  ExpectFailure(upload({"--intrinsics", "525,525,9999,240"}), 1, "640 x 360");
  EXPECT_TRUE(maps_.maps.empty());
  EXPECT_EQ(ingest_.streams_opened(), 0U);
  EXPECT_EQ(Run(upload({"--depth-scale", "0.001", "--intrinsics", "461,461,325,178"})).exit_code,
            0);
}

TEST_F(UploadCommandTest, TimesBefore2000AreWarnedAbout) {
  const std::string recording = PathOf("recording");
  ASSERT_EQ(Run({"simulate", "--write", recording, "--route", "twin", "--stride", "40"}).exit_code,
            0);
  const auto upload = [&] {
    return Run({"upload", "k", "--policy", "static", "--format", "torwic", recording});
  };
  EXPECT_EQ(upload().err.find("before 2000"), std::string::npos);
  for (const auto& sequence : std::filesystem::directory_iterator(recording)) {
    const std::filesystem::path poses = sequence.path() / "poses.txt";
    std::ostringstream moved;
    std::ifstream lines(poses);
    std::string id;
    std::string seconds;
    for (std::string rest; lines >> id >> seconds && std::getline(lines, rest);) {
      moved << id << ' ' << std::stoll(seconds) - 1'600'000'000 << rest << '\n';
    }
    lines.close();
    std::ofstream(poses) << moved.str();
  }
  const Outcome outcome = upload();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("the recording begins at 1971-"), std::string::npos) << outcome.err;
}

TEST_F(UploadCommandTest, FramesThatTheServerLostAreSentAgain) {
  std::vector<std::uint64_t> received;
  ingest_.SetScripts({[](ScriptedStream& stream) {
                        stream.ReadOpen();
                        stream.SendOpened(0, 1'000);
                        EXPECT_TRUE(stream.ReadUntil(3));
                        stream.SendAck(v1::ACK_LEVEL_DURABLE, 3);
                        return grpc::Status(grpc::StatusCode::UNAVAILABLE, "the server stops");
                      },
                      [&received](ScriptedStream& stream) {
                        stream.ReadOpen();
                        stream.SendOpened(1, 1'000);
                        grpc::Status status = stream.AcceptRest();
                        received = stream.received();
                        return status;
                      }});
  const Outcome outcome = Run(
      {"simulate", "demo", "--policy", "static", "--route", "twin", "--stride", "20", "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("lost the frames 2 to 3, which it had acknowledged"),
            std::string::npos)
      << outcome.err;
  ASSERT_GE(received.size(), 2U);
  EXPECT_EQ(received.front(), 2U);
  EXPECT_EQ(outcome.Document().at("frames"), received.back());
  EXPECT_EQ(outcome.Document().at("integrated"), received.back());
}

class RefusingServerTest : public CommandLineTest {
 protected:
  RefusingServerTest() {
    ingest_.SetScripts({[](ScriptedStream& stream) {
      stream.ReadOpen();
      stream.SendOpened(0, 1'000);
      v1::FrameBatch batch;
      while (stream.ReadBatch(&batch)) {
      }
      v1::RefusedFrame refused;
      refused.set_client_seq(2);
      *refused.mutable_status() =
          ToProto(InvalidField(reason::kLabelOutOfRange, "frames[1].labels", "label 99"));
      stream.SendAck(v1::ACK_LEVEL_INTEGRATED, stream.received().back(), {refused});
      return grpc::Status::OK;
    }});
  }
};

TEST_F(RefusingServerTest, RefusedFramesFailTheCommandButNotTheUpload) {
  const Outcome outcome =
      Run({"simulate", "demo", "--policy", "static", "--route", "twin", "--stride", "40"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.out.find(" 1 refused"), std::string::npos);
  EXPECT_NE(outcome.err.find(" frames integrated, 1 refused (LABEL_OUT_OF_RANGE), "),
            std::string::npos)
      << outcome.err;
  EXPECT_NE(outcome.err.find("the first was frame 2: label 99 [LABEL_OUT_OF_RANGE, "
                             "frames[1].labels]"),
            std::string::npos)
      << outcome.err;
}

}  // namespace
}  // namespace steadymap
