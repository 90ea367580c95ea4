#include "core/policy/engine_parameters.h"

#include <algorithm>

#include "core/policy/configured_parameters.h"
#include "core/policy/paper_mapper.h"
#include "core/types/policy_parameters.h"

namespace steadymap {
namespace {

void FollowPaperInAssociation(const Ablation& switches,
                              const PaperParameters& paper,
                              ClusterParameters* clusters) {
  if (!switches.cuboid_gate) clusters->center_distance_m = paper.association_distance_m;
  if (!switches.many_to_one) {
    clusters->is_one_to_one = true;
    clusters->max_dissimilarity = paper.max_dissimilarity;
  }
}

void FollowPaperInVisibility(const Ablation& switches,
                             const PaperParameters& paper,
                             const MapConfig& config,
                             VisibilityParameters* visibility) {
  if (!switches.visibility_by_depth) {
    visibility->is_by_depth = false;
    visibility->min_visible_share = paper.min_visible_share;
    visibility->max_depth_m = config.max_depth_m;
  }
  if (!switches.far_labels) visibility->sure_depth_m = 0.0;
  if (!switches.replacing) visibility->replaced_within_m = 0.0;
  if (!switches.turning) visibility->turn.turned_rad = 0.0;
  if (!switches.clean_change) {
    visibility->change.truncation_m = config.truncation_m;
    visibility->change.subtracts_noise = paper.change.subtracts_noise;
  }
}

void FollowPaperInJudgement(const Ablation& switches,
                            const PaperParameters& paper,
                            BeliefUpdateParameters* judgement) {
  if (!switches.gathering) judgement->cells_per_update = 1.0;
  if (!switches.evidence_cap) {
    judgement->stationarity.max_evidence = paper.stationarity.max_evidence;
    judgement->revisit_evidence = paper.stationarity.max_evidence;
  }
}

void FollowPaperInConfirmation(const Ablation& switches, ObjectLifecycleParameters* confirmation) {
  if (!switches.turning) confirmation->recognition.turn.turned_rad = 0.0;
  if (!switches.tentative) confirmation->views = 1;
  confirmation->recognises_returned = switches.returning;
  confirmation->recognises_rests = switches.splitting;
  confirmation->recognises_pieces = switches.merging;
}

/// The same for things that are smaller by a factor.
PieceParameters Shrink(PieceParameters piece, double factor) {
  piece.size_m *= factor;
  piece.distance_m *= factor;
  return piece;
}

}  // namespace

ObjectMapperParameters ParametersFor(const MapConfig& config, const Ablation& switches) {
  const PaperParameters paper;
  ObjectMapperParameters parameters;
  // The smallest things are those of a warehouse; a finer map is of smaller ones.
  const double finer = std::min(1.0, config.truncation_m / VoxelScale().truncation_m);
  parameters.confirmation.min_area_m2 *= finer * finer;
  parameters.min_seen_area_m2 *= finer * finer;
  parameters.max_mislabelled_area_m2 *= finer * finer;
  ReidentificationParameters& recognition = parameters.confirmation.recognition;
  recognition.fixture = Shrink(recognition.fixture, finer);
  recognition.thing = Shrink(recognition.thing, finer);
  parameters.visibility.truncation_m = config.truncation_m;
  parameters.visibility.sure_depth_m = config.max_depth_m;
  parameters.guard.is_on = switches.robot_guard;
  parameters.moving.is_on = switches.moving_memory;
  parameters.min_stationarity = ParameterValue(config, "min_stationarity");
  parameters.confirmation.initial_stationarity = ParameterValue(config, "initial_stationarity");
  ReadStationarity(config, &parameters.judgement.stationarity);
  parameters.judgement.stationarity.max_evidence = ParameterValue(config, "max_evidence");
  FollowPaperInAssociation(switches, paper, &parameters.clusters);
  FollowPaperInVisibility(switches, paper, config, &parameters.visibility);
  FollowPaperInJudgement(switches, paper, &parameters.judgement);
  FollowPaperInConfirmation(switches, &parameters.confirmation);
  if (!switches.merging) parameters.merging.contacts = 0;
  parameters.cuts_gone_parts = switches.splitting;
  parameters.keeps_removed = switches.archive;
  parameters.finds_moves = switches.moves;
  parameters.remembers_free_space = switches.free_space;
  return parameters;
}

}  // namespace steadymap
