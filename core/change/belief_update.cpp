#include "core/change/belief_update.h"

#include <algorithm>

#include "core/working/object_split.h"

namespace steadymap {
namespace {

// One look that finds a surface outweighs all that missed it but two: what was hidden for long and
// is seen again must not fall to the next bad frame, nor stay doubted.
constexpr int kDoubtThatRemains = -2;

}  // namespace

StationarityPrior PriorOf(const MapConfig& config, ClassId class_id) {
  const SemanticClass* row = config.FindClass(class_id);
  return row == nullptr || row->motion == ClassMotion::kStatic ? StationarityPrior::kStationary
                                                               : StationarityPrior::kMobile;
}

void AddEvidence(const ObjectVerdict& verdict,
                 const ObjectSurface& surface,
                 Timestamp now,
                 double visit_gap_s,
                 ObjectEvidence* evidence) {
  if ((now - evidence->LastConfirmed()).seconds() > visit_gap_s) {
    evidence->present_cells = 0.0;
    evidence->change_sum_m = 0.0;
    // What was missed before is missed still, unless it is found now.
    if (verdict.present > 0) evidence->absent_cells = 0.0;
  }
  for (const CellVerdict& judged : verdict.cells) {
    LeafEvidence& leaf = evidence->MutableLeaf(surface.leaves()[judged.leaf].origin);
    std::int8_t& score = leaf.score[judged.cell];
    if (judged.verdict == Verdict::kPresent) {
      const int raised = std::max<int>(score, kDoubtThatRemains) + 1;
      score = static_cast<std::int8_t>(std::min<int>(raised, kMaxCellScore));
      if (now - leaf.confirmed >= kConfirmationGrain) {
        leaf.confirmed = now;
      }
    } else {
      score = static_cast<std::int8_t>(std::max<int>(score - 1, kMinCellScore));
    }
  }
  const auto present = static_cast<double>(verdict.present);
  const auto absent = static_cast<double>(verdict.absent());
  evidence->present_cells += present;
  evidence->absent_cells += absent;
  evidence->change_sum_m += present * verdict.change_m.value_or(0.0);
  evidence->absent_streak_cells = present > absent ? 0.0 : evidence->absent_streak_cells + absent;
}

bool UpdateBelief(StationarityPrior prior,
                  Timestamp now,
                  const BeliefUpdateParameters& parameters,
                  ObjectState* object) {
  ObjectEvidence& evidence = object->evidence;
  const double judged = evidence.present_cells + evidence.absent_cells;
  if (judged < parameters.cells_per_update) return false;
  StationarityParameters stationarity = parameters.stationarity;
  if (prior == StationarityPrior::kStationary &&
      (now - object->last_seen).seconds() > parameters.visit_gap_s) {
    stationarity.max_evidence = std::min(stationarity.max_evidence, parameters.revisit_evidence);
  }
  const double absent_share = evidence.absent_cells / judged;
  const double found_change_m =
      evidence.present_cells > 0.0 ? evidence.change_sum_m / evidence.present_cells : 0.0;
  evidence.present_cells = 0.0;
  evidence.absent_cells = 0.0;
  evidence.change_sum_m = 0.0;
  if (absent_share >= parameters.absent_share) {
    ++object->contradicted_updates;
    const double change_m = stationarity.max_change_m;
    object->belief = UpdateStationarity(object->belief, change_m, prior, stationarity).belief;
  } else if (absent_share < parameters.present_share) {
    object->last_seen = now;
    object->belief = UpdateStationarity(object->belief, found_change_m, prior, stationarity).belief;
  }
  return true;
}

bool IsContradicted(const ObjectVerdict& verdict,
                    Timestamp now,
                    const ContradictionParameters& parameters,
                    const TrackedObject& object) {
  const DoubtedCells cells = CountDoubtedCells(object, -1);
  const std::size_t contradicted = std::max(cells.doubted, verdict.absent());
  const auto found =
      static_cast<double>(CountFoundCells(object, now - Duration::FromSeconds(parameters.found_s)));
  if (found > parameters.found_ratio * static_cast<double>(contradicted) &&
      object.state().belief.stationarity() >= parameters.least_stationarity) {
    return false;
  }
  const double unseen_s = (now - object.state().last_seen).seconds();
  return unseen_s > parameters.visit_s || contradicted >= parameters.cells ||
         static_cast<double>(contradicted) >= parameters.share * static_cast<double>(cells.all);
}

}  // namespace steadymap
