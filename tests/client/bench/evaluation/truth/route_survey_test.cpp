#include "client/bench/evaluation/truth/route_survey.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "client/bench/evaluation/score/route_reference.h"
#include "client/bench/evaluation/truth/event_truth.h"
#include "client/bench/simulator/routes/named_routes.h"

namespace steadymap {
namespace {

// A static camera at (-2, 0, 1) facing +x.
Trajectory Stand(double duration_s) {
  Trajectory trajectory;
  trajectory.duration_s = duration_s;
  trajectory.T_world_camera = [](double) { return LookAt({-2, 0, 1}, {0, 0, 1}); };
  return trajectory;
}

// Two frames of a box in front of a wall, then three in which the box has been removed or, with
// `moves`, has moved one metre to the left.
Route BoxGoes(bool moves) {
  Scene before;
  AddStandingBox(&before, "wall", {0.1, 4.0, 3.0}, {0.8, 0, 0}).semantic_class = SceneClass::kWall;
  const std::uint16_t box = AddStandingBox(&before, "box", {0.5, 0.5, 2.0}, {0, 0, 0}).id;
  Scene after = before;
  if (moves) {
    for (SceneObject& object : after.objects()) {
      if (object.id == box) object.T_world_object.translation().y() = 1.0;
    }
  } else {
    after.RemoveIf([box](const SceneObject& object) { return object.id == box; });
  }
  Route route;
  route.name = "box-goes";
  route.camera = {160, 120, 115.0, 115.0, 79.5, 59.5};
  route.sequences.push_back({"before", before, Stand(0.1)});
  route.sequences.push_back({"after", after, Stand(0.2)});
  return route;
}

RouteSurvey Survey(const Route& route) {
  return SurveyRoute(Simulation(route, SimulationOptions()), SurveyOptions());
}

double Area(const std::vector<SurfacePoint>& points, const RouteSurvey& survey) {
  return static_cast<double>(points.size()) * survey.point_area_m2;
}

TEST(SurveyRoute, KnowsEachPlaceAndWhoSawIt) {
  const RouteSurvey survey = Survey(BoxGoes(true));
  ASSERT_EQ(survey.places.size(), 3U);
  EXPECT_EQ(survey.first_frames, (std::vector<std::size_t>{0, 2, 5}));
  const SurveyedPlace& wall = survey.places[0];
  const SurveyedPlace& left = survey.places[1];
  const SurveyedPlace& taken = survey.places[2];
  EXPECT_EQ(wall.stands_in, 3U);
  EXPECT_EQ(left.stands_in, 1U);
  EXPECT_EQ(taken.stands_in, 2U);
  EXPECT_EQ(left.object, taken.object);
  EXPECT_EQ(left.frames_in_view, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
  EXPECT_NEAR(taken.box_world.center().y(), 1.0, 0.02);
}

// A box that slides 1 m to the left within 1 s, in front of a wall.
Route BoxSlides() {
  Scene scene;
  AddStandingBox(&scene, "wall", {0.1, 4.0, 3.0}, {0.8, 0, 0}).semantic_class = SceneClass::kWall;
  SceneObject& box = AddStandingBox(&scene, "box", {0.5, 0.5, 2.0}, {0, -0.5, 0});
  box.semantic_class = SceneClass::kDynamicFeature;
  const Eigen::Isometry3d start = box.T_world_object;
  box.motion = {{0.0, start}, {1.0, Eigen::Translation3d(0, 1, 0) * start}};
  Route route;
  route.name = "box-slides";
  route.camera = {160, 120, 115.0, 115.0, 79.5, 59.5};
  route.sequences.push_back({"slides", scene, Stand(1.0)});
  return route;
}

TEST(SurveyRoute, KnowsWhereMovingThingsWereSeen) {
  RouteSurvey survey = Survey(BoxSlides());
  ASSERT_EQ(survey.places.size(), 1U) << "only the wall: moving objects have no place";
  ASSERT_FALSE(survey.swept.empty());
  Eigen::AlignedBox3f swept;
  for (const SurfacePoint& point : survey.swept) swept.extend(point.position_world);
  EXPECT_NEAR(swept.min().x(), -0.25F, 0.02F) << "its front";
  EXPECT_NEAR(swept.min().y(), -0.75F, 0.1F);
  EXPECT_NEAR(swept.max().y(), 0.75F, 0.1F);
  const Reference reference = MakeReference(&survey, false);
  EXPECT_EQ(reference.swept.size(), survey.swept.size()) << "far from all true surface";
  EXPECT_TRUE(Survey(BoxGoes(true)).swept.empty());
}

TEST(SurveyRoute, SeesFrontsAndLooksThroughWhatIsGone) {
  const RouteSurvey survey = Survey(BoxGoes(false));
  const SurveyedPlace& box = survey.places[1];
  for (std::size_t i = 0; i < box.points.size(); ++i) {
    const SurfacePoint& point = box.points[i];
    // Lower points have no surface behind them: without a floor, the rays pass below the wall.
    const bool is_front =
        point.normal_world.x() < -0.9F && std::abs(point.position_world.z() - 1.0F) < 0.6F;
    const bool is_back = point.normal_world.x() > 0.9F;
    if (is_front) {
      EXPECT_EQ(box.seen_in[i], 1U) << point.position_world.transpose();
      EXPECT_EQ(box.looked_through_in[i], 2U) << point.position_world.transpose();
    }
    if (is_back) {
      EXPECT_EQ(box.seen_in[i], 0U);
    }
  }
}

TEST(MakeReference, SortsSurfaceByWhoSawIt) {
  RouteSurvey survey = Survey(BoxGoes(false));
  const Reference reference = MakeReference(&survey, false);
  // The part of the box's front with wall behind it, inside the picture: 0.5 m x 1.55 m.
  EXPECT_NEAR(Area(reference.vanished, survey), 0.775, 0.05);
  EXPECT_TRUE(reference.remembered.empty());
  EXPECT_GT(Area(reference.seen, survey), 5.0);
  EXPECT_GT(Area(reference.unseen, survey), 12.0) << "the back of the wall";
}

TEST(MakeReference, WhatANewThingHidesIsRemembered) {
  Route route = BoxGoes(false);
  std::swap(route.sequences[0].scene, route.sequences[1].scene);
  RouteSurvey survey = Survey(route);
  const Reference reference = MakeReference(&survey, false);
  EXPECT_TRUE(reference.vanished.empty());
  EXPECT_GT(Area(reference.remembered, survey), 0.9);
  for (const SurfacePoint& point : reference.remembered) {
    EXPECT_NEAR(point.position_world.x(), 0.75, 0.01);
    EXPECT_LT(std::abs(point.position_world.y()), 0.6F);
  }
}

TEST(ListTrueEvents, ARemovalInView) {
  const Route route = BoxGoes(false);
  const EventTruth truth = ListTrueEvents(route, Survey(route));
  ASSERT_EQ(truth.changes.size(), 1U);
  const TrueChange& change = truth.changes[0];
  EXPECT_EQ(change.name, "box");
  EXPECT_EQ(change.sequence, 1U);
  EXPECT_EQ(change.class_id, ClassId(7));
  EXPECT_TRUE(change.departure.is_in_view);
  EXPECT_TRUE(change.arrival.boxes_world.empty());
  EXPECT_EQ(change.departure.frames_in_view, (std::vector<std::size_t>{2, 3, 4}));
}

TEST(ListTrueEvents, AMoveHasBothEnds) {
  const Route route = BoxGoes(true);
  const EventTruth truth = ListTrueEvents(route, Survey(route));
  ASSERT_EQ(truth.changes.size(), 1U);
  EXPECT_TRUE(truth.changes[0].is_move());
  EXPECT_TRUE(truth.changes[0].departure.is_in_view);
  EXPECT_TRUE(truth.changes[0].arrival.is_in_view);
}

TEST(ListTrueEvents, WhatIsHiddenIsNotInView) {
  Route route = BoxGoes(false);
  for (RouteSequence& sequence : route.sequences) {
    AddStandingBox(&sequence.scene, "screen", {0.1, 3.0, 3.0}, {-1, 0, 0});
  }
  const EventTruth truth = ListTrueEvents(route, Survey(route));
  ASSERT_EQ(truth.changes.size(), 1U);
  EXPECT_FALSE(truth.changes[0].departure.is_in_view);
  EXPECT_TRUE(truth.changes[0].departure.frames_in_view.empty());
}

TEST(ListTrueEvents, ThingsOfAGroupThatChangeAlikeAreOneChange) {
  const Route route = *MakeRoute("2-1");
  SimulationOptions options;
  options.stride = 12;
  const EventTruth truth =
      ListTrueEvents(route, SurveyRoute(Simulation(route, options), SurveyOptions()));
  ASSERT_EQ(truth.changes.size(), 3U) << "three piles of two stacks";
  for (const TrueChange& change : truth.changes) {
    EXPECT_EQ(change.departure.boxes_world.size(), 2U);
    EXPECT_TRUE(change.departure.is_in_view) << change.name;
  }
}

}  // namespace
}  // namespace steadymap
