#include "client/bench/evaluation/route_evaluation.h"

#include <cmath>
#include <filesystem>
#include <map>

#include <gtest/gtest.h>

#include "client/bench/evaluation/recording_evaluation.h"
#include "client/bench/simulator/routes/named_routes.h"
#include "client/bench/simulator/torwic_writer.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

RouteEvaluationOptions Options(const SensorModel& sensor, std::size_t stride) {
  RouteEvaluationOptions options;
  options.simulation.sensor = sensor;
  options.simulation.stride = stride;
  options.methods = SelectMethods({}, MapConfig()).value();
  return options;
}

const MethodScore& Row(const Evaluation& evaluation, const std::string& name) {
  for (const MethodScore& row : evaluation.rows) {
    if (row.name == name) return row;
  }
  ADD_FAILURE() << "no row " << name;
  return evaluation.rows.front();
}

TEST(EvaluateRoute, YardsticksBracketWhatAMapCanBe) {
  const auto evaluation =
      EvaluateRoute(MakeRoute("1-5").value(), Options(SensorModel::Ideal(), 12));
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  const MapScore& fused = Row(*evaluation, "static").map;
  const MapScore& fresh = Row(*evaluation, "fresh").map;
  EXPECT_GT(fresh.near.precision(), 0.97);
  EXPECT_GT(fresh.near.precision(), fused.near.precision() + 0.1);
  EXPECT_GT(fused.near.recall(), 0.9);
  EXPECT_LT(fresh.near.false_positive_rate(), 0.2 * fused.near.false_positive_rate());
  EXPECT_GT(fused.ghosts.value(), 0.5);
  EXPECT_LT(fresh.ghosts.value(), 0.05);
  EXPECT_GT(fused.kept.value(), 0.8);
  EXPECT_LT(fresh.kept.value(), 0.05);
  EXPECT_GT(fused.ghosts.whole, 100U);
  EXPECT_GT(fused.kept.whole, 100U);
}

TEST(EvaluateRoute, AnUnchangedRouteHasNoGhosts) {
  RouteEvaluationOptions options = Options(SensorModel::Full(), 12);
  options.seeds = {1, 2};
  std::map<std::string, std::size_t> visits;
  options.visit_map = [&visits](const std::string& method, const MapScorer&, const MethodOutcome&) {
    ++visits[method];
  };
  const auto evaluation = EvaluateRoute(MakeRoute("baseline").value(), options);
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  const MethodScore& row = Row(*evaluation, "static");
  EXPECT_EQ(row.map.ghosts.whole, 0U);
  EXPECT_GT(row.map.near.precision(), 0.95);
  EXPECT_GT(row.map.near.recall(), 0.85);
  EXPECT_GT(row.cost.memory_bytes, 100'000U);
  EXPECT_EQ(visits.size(), MethodNames().size());
  for (const std::string& method : MethodNames()) EXPECT_EQ(visits[method], 1U) << method;
}

TEST(EvaluateRoute, PocdForgetsWhatMovedAndKeepsWhatIsOutOfView) {
  const auto evaluation = EvaluateRoute(MakeRoute("1-5").value(), Options(SensorModel::Full(), 2));
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  const MapScore& pocd = Row(*evaluation, "pocd").map;
  const MapScore& fresh = Row(*evaluation, "fresh").map;
  EXPECT_GT(pocd.near.precision(), fresh.near.precision() - 0.015);
  EXPECT_GT(pocd.near.recall(), fresh.near.recall() - 0.015);
  EXPECT_LT(pocd.near.false_positive_rate(), fresh.near.false_positive_rate() + 0.003);
  EXPECT_LT(pocd.ghosts.value(), 0.03);
  EXPECT_GT(pocd.kept.value(), 0.85);
  EXPECT_LT(Row(*evaluation, "pocd").brier, 0.15);
  EXPECT_TRUE(std::isnan(Row(*evaluation, "static").brier)) << "it has no beliefs";
  EXPECT_GT(evaluation->claimed_poses.rms_m(), 0.005);
  EXPECT_LT(Row(*evaluation, "pocd").registered_poses.rms_m(), 0.03);
  EXPECT_TRUE(std::isnan(Row(*evaluation, "static").registered_poses.rms_m()));
  EXPECT_GT(Row(*evaluation, "pocd").cost.bytes_per_object, 1e4);
  EXPECT_GT(Row(*evaluation, "pocd").cost.delta_bytes_per_frame, 1e3);
  for (const MethodScore& row : evaluation->rows) {
    if (row.name == "fresh" || row.name == "pocd") continue;
    SCOPED_TRACE(row.name);
    EXPECT_GT(pocd.near.precision(), row.map.near.precision());
    EXPECT_LT(pocd.near.false_positive_rate(), row.map.near.false_positive_rate());
  }
}

TEST(EvaluateRoute, PeopleLeaveNoTrail) {
  RouteEvaluationOptions options = Options(SensorModel::Full(), 3);
  options.methods = SelectMethods({"pocd"}, MapConfig()).value();
  const auto evaluation = EvaluateRoute(MakeRoute("people").value(), options);
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  const Share& trail = Row(*evaluation, "pocd").map.trail;
  EXPECT_GT(trail.whole, 500U);
  EXPECT_LE(trail.value(), 0.01);
}

TEST(EvaluateRoute, CarsLeaveNoTrailThoughSomeFramesTakeThemForSomethingElse) {
  RouteEvaluationOptions options = Options(SensorModel::Full(), 3);
  options.voxel_size_m = EvaluationVoxelFor("table-top");
  options.methods = SelectMethods({"pocd"}, MapConfigFor("table-top")).value();
  const auto evaluation = EvaluateRoute(MakeRoute("table-top").value(), options);
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  const Share& trail = Row(*evaluation, "pocd").map.trail;
  EXPECT_GT(trail.whole, 200U);
  EXPECT_LE(trail.value(), 0.03);
}

TEST(EvaluateRoute, TellsWhereTheTimeOfAFrameGoes) {
  RouteEvaluationOptions options = Options(SensorModel::Ideal(), 40);
  options.methods = SelectMethods({"pocd"}, MapConfig()).value();
  const auto evaluation = EvaluateRoute(MakeRoute("twin").value(), options);
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  const auto spent_ms = [&](const std::string& name, MapperStage stage) {
    return Row(*evaluation, name).cost.stage_ms[static_cast<std::size_t>(stage)];
  };
  EXPECT_GT(spent_ms("pocd", MapperStage::kAssociation), 0.0);
  EXPECT_GT(spent_ms("pocd", MapperStage::kCommit), 0.0);
  EXPECT_GT(spent_ms("static", MapperStage::kPolicy), 0.0);
  EXPECT_EQ(spent_ms("static", MapperStage::kAssociation), 0.0);
}

TEST(EvaluateRoute, EveryBaselineIsMorePreciseThanStatic) {
  const auto evaluation = EvaluateRoute(MakeRoute("1-5").value(), Options(SensorModel::Full(), 3));
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  const MapScore& fused = Row(*evaluation, "static").map;
  for (const char* name : {"voxel_change", "submap_change", "tracking"}) {
    SCOPED_TRACE(name);
    const MapScore& map = Row(*evaluation, name).map;
    EXPECT_GT(map.near.precision(), fused.near.precision());
    EXPECT_GT(map.near.recall(), 0.7);
  }
}

TEST(EvaluateRecording, TheMapOfTheLastSequenceIsTheTruth) {
  const TemporaryFolder folder;
  SimulationOptions simulation;
  simulation.sensor = SensorModel::Ideal();
  simulation.stride = 40;
  ASSERT_TRUE(WriteTorwicFolder(MakeRoute("1-2").value(), folder.path(), simulation).ok());
  RecordingEvaluationOptions options;
  options.format = "torwic";
  options.sequences = {folder.path() / "01-baseline", folder.path() / "02-1-2"};
  options.methods = SelectMethods({}, MapConfig()).value();
  const auto evaluation = EvaluateRecording(options);
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  EXPECT_EQ(Row(*evaluation, "fresh").map.voxel.precision(), 1.0);
  EXPECT_EQ(Row(*evaluation, "fresh").map.voxel.recall(), 1.0);
  EXPECT_LT(Row(*evaluation, "static").map.voxel.precision(), 0.98);
  EXPECT_GT(Row(*evaluation, "static").map.voxel.recall(), 0.98);
  EXPECT_EQ(evaluation->frame_count, 20U);
  EXPECT_FALSE(evaluation->has_history);
}

TEST(EvaluateRecording, WhatIsMissingIsAnError) {
  RecordingEvaluationOptions options;
  options.format = "torwic";
  options.methods = SelectMethods({}, MapConfig()).value();
  EXPECT_EQ(EvaluateRecording(options).status().code(), absl::StatusCode::kInvalidArgument);
  const TemporaryFolder folder;
  options.sequences = {folder.path() / "none"};
  EXPECT_EQ(EvaluateRecording(options).status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace steadymap
