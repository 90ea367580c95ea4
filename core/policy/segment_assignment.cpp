#include "core/policy/segment_assignment.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "core/objects/part_votes.h"
#include "core/objects/surface_parts.h"
#include "core/objects/unsegmented_surface.h"

namespace steadymap {
namespace {

/// True if a segment is so narrow in the image that its shape cannot be told from noise.
bool IsUnresolved(const FrameSegment& segment, double min_width, const SampleGrid& samples) {
  const auto columns = static_cast<std::size_t>(samples.width());
  Eigen::AlignedBox2d bounds;
  for (const std::size_t index : segment.samples) {
    const std::size_t row = index / columns;
    bounds.extend(Eigen::Vector2d(static_cast<double>(index % columns), static_cast<double>(row)));
  }
  const double length = (bounds.sizes() + Eigen::Vector2d::Ones()).norm();
  return static_cast<double>(segment.samples.size()) < min_width * length;
}

}  // namespace

/// Returns what segments and objects of the session have in common, the largest first. Samples that
/// are marked in `is_excluded`, if it is not empty, do not count.
std::vector<SegmentAssignment::Claim> SegmentAssignment::FindClaims(
    std::span<const char> is_excluded) const {
  std::map<std::pair<std::size_t, std::size_t>, double> areas_m2;  // By place and segment.
  for (const SampleOnObject& found : frame_.on_objects) {
    const std::size_t segment = segment_of_[found.sample];
    if (segment == 0 || (!is_excluded.empty() && is_excluded[found.sample] != 0)) continue;
    areas_m2[{found.place, segment - 1}] +=
        static_cast<double>(frame_.samples[found.sample].area_m2);
  }
  std::vector<Claim> claims;
  for (const auto& [key, area_m2] : areas_m2) {
    const auto& [place, segment] = key;
    const double smaller_m2 =
        std::min((*in_view_)[place].object->SurfaceAreaM2(), frame_.segments[segment].area_m2);
    claims.push_back({segment, place, area_m2, area_m2 / smaller_m2});
  }
  std::stable_sort(claims.begin(), claims.end(), [](const Claim& a, const Claim& b) {
    return a.area_m2 > b.area_m2;
  });
  return claims;
}

/// True if a segment shows the object of a claim.
bool SegmentAssignment::IsOfObject(const Claim& claim) const {
  const FrameSegment& segment = frame_.segments[claim.segment];
  if ((*in_view_)[claim.place].object->state().class_id.value() == segment.label) {
    return claim.share >= identity_.parts.shares.substantial;
  }
  return claim.area_m2 >= identity_.parts.shares.most() * segment.area_m2;
}

void SegmentAssignment::AssignScene() {
  association_.owner.assign(frame_.samples.size(), Association::kNone);
  segment_of_.assign(frame_.samples.size(), 0);
  for (std::size_t index = 0; index < frame_.samples.size(); ++index) {
    if (frame_.samples[index].is_valid()) association_.owner[index] = kBackgroundOwner;
  }
  for (const SampleOnObject& found : frame_.on_objects) {
    if (!IsStructure(*(*in_view_)[found.place].object, identity_.parts.scene)) continue;
    association_.owner[found.sample] = static_cast<std::uint32_t>(found.place + 1);
  }
  owner_of_.assign(frame_.segments.size(), 0);
  segment_on_.assign(in_view_->size(), 0);
  if (frame_.segments.empty()) return;
  for (std::size_t place = 0; place < in_view_->size(); ++place) {
    const ObjectState& state = (*in_view_)[place].object->state();
    if (state.status == ObjectStatus::kTentative && !HasGivenExtent(state)) {
      owner_of_.front() = place + 1;
    }
  }
  if (owner_of_.front() == 0) AddSegmentAsObject(0);
  for (const std::size_t index : frame_.segments.front().samples) {
    segment_of_[index] = 1;
    association_.owner[index] =
        owner_of_.front() == 0 ? Association::kNone : static_cast<std::uint32_t>(owner_of_.front());
  }
}

void SegmentAssignment::AssignSegments() {
  SeparateBackground();
  for (std::size_t place = 0; place < in_view_->size(); ++place) {
    const TrackedObject& object = *(*in_view_)[place].object;
    if (IsUnsegmented(object)) unsegmented_.emplace(object.state().class_id, place);
  }
  claims_ = FindClaims({});
  ChooseObjects();
  for (std::size_t i = 0; i < frame_.segments.size(); ++i) {
    if (segment_of_[frame_.segments[i].samples.front()] == 0) continue;
    if (owner_of_[i] == 0 && contested_[i] != 0) SeparateContested(i);
    if (owner_of_[i] == 0) AddSegmentAsObject(i);
  }
  Vote();
  SetOwners();
  SetAside();
}

void SegmentAssignment::SeparateBackground() {
  association_.owner.assign(frame_.samples.size(), Association::kNone);
  segment_of_.assign(frame_.samples.size(), 0);
  for (std::size_t i = 0; i < frame_.segments.size(); ++i) {
    const bool is_background = frame_.segments[i].instance == 0 &&
                               config_.IsInBackground(ClassId(frame_.segments[i].label));
    for (const std::size_t index : frame_.segments[i].samples) {
      if (is_background) {
        association_.owner[index] = kBackgroundOwner;
      } else {
        segment_of_[index] = i + 1;
      }
    }
  }
}

/// Gives each segment to the object with which it has most surface in common, one segment to an
/// object.
void SegmentAssignment::ChooseObjects() {
  owner_of_.assign(frame_.segments.size(), 0);
  contested_.assign(frame_.segments.size(), 0);
  segment_on_.assign(in_view_->size(), 0);
  for (const Claim& claim : claims_) {
    if ((*in_view_)[claim.place].object->is_archived() || !IsOfObject(claim)) continue;
    if (owner_of_[claim.segment] != 0) continue;
    if (segment_on_[claim.place] == 0) {
      owner_of_[claim.segment] = claim.place + 1;
      segment_on_[claim.place] = claim.segment + 1;
    } else if (contested_[claim.segment] == 0) {
      contested_[claim.segment] = claim.place + 1;
    }
  }
}

/// Divides an object that two segments show apart: the surface nearer to the samples of the segment
/// `index` becomes a new object.
void SegmentAssignment::SeparateContested(std::size_t index) {
  const std::size_t place = contested_[index] - 1;
  TrackedObject* whole = (*in_view_)[place].object;
  if (frame_.segments[index].area_m2 < parameters_.min_new_area_m2) {
    owner_of_[index] = contested_[index];
    return;
  }
  const std::vector<OrientedPoint> points = OrientedSurfaceOf(*whole);
  const std::vector<std::size_t> part_of =
      SpreadParts(points,
                  FindSeeds(index),
                  identity_.parts.surface.contact_voxels * map_->scale().voxel_size_m);
  if (std::find(part_of.begin(), part_of.end(), std::size_t{1}) == part_of.end()) return;
  TrackedObject* part = DivideVoxels(whole, part_of, 1, map_).front();
  InheritVotes(*whole, part, map_);
  AddInView(part, index);
}

/// Returns the surface points of an object that two segments show apart, with their part: 1 where
/// the segment `index` is, 0 where the other one is.
std::vector<std::pair<std::size_t, std::size_t>> SegmentAssignment::FindSeeds(
    std::size_t index) const {
  const std::size_t place = contested_[index] - 1;
  const std::vector<OrientedPoint> points = OrientedSurfaceOf(*(*in_view_)[place].object);
  const Eigen::Isometry3d T_camera_world = frame_.cloud.T_world_camera().inverse();
  std::vector<std::pair<std::size_t, std::size_t>> seeds;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d point_camera = T_camera_world * points[i].position_world;
    if (point_camera.z() <= 0.0) continue;
    const std::optional<SamplePlace> at =
        frame_.samples.FindPlace(frame_.cloud.camera(), point_camera.cast<float>());
    if (!at) continue;
    const std::size_t sample_index = frame_.samples.Index(at->column, at->row);
    const SurfaceSample& sample = frame_.samples[sample_index];
    const std::size_t segment = segment_of_[sample_index];
    if (!sample.is_valid() || segment == 0) continue;
    // A point belongs to the segment of the sample that it projects to, if it is near that sample.
    const double distance_m =
        (sample.position_world.cast<double>() - points[i].position_world).norm();
    if (distance_m > identity_.parts.scene.near_voxels * map_->scale().voxel_size_m) continue;
    if (segment == index + 1) seeds.emplace_back(i, 1);
    if (segment == segment_on_[place]) seeds.emplace_back(i, 0);
  }
  return seeds;
}

void SegmentAssignment::AddInView(TrackedObject* object, std::size_t segment) {
  in_view_->push_back({object, 0, frame_.samples.width(), 0, frame_.samples.height()});
  owner_of_[segment] = in_view_->size();
  segment_on_.push_back(segment + 1);
}

/// Marks the samples on the surface of the object to which their segment is given.
std::vector<char> SegmentAssignment::FindSamplesOnOwner() const {
  std::vector<char> is_on_owner(frame_.samples.size(), 0);
  for (const SampleOnObject& found : frame_.on_objects) {
    const std::size_t segment = segment_of_[found.sample];
    if (segment != 0 && owner_of_[segment - 1] == found.place + 1) is_on_owner[found.sample] = 1;
  }
  return is_on_owner;
}

/// Takes the samples that are also on the object of their own segment out of the claims of
/// instances: where two instances touch, these tell nothing.
void SegmentAssignment::ExcludeContactsOfInstances() {
  const std::vector<FrameSegment>& segments = frame_.segments;
  const auto is_instance = [](const FrameSegment& segment) { return segment.instance != 0; };
  if (std::none_of(segments.begin(), segments.end(), is_instance)) return;
  std::vector<char> is_excluded = FindSamplesOnOwner();
  for (std::size_t i = 0; i < is_excluded.size(); ++i) {
    if (segment_of_[i] != 0 && !is_instance(segments[segment_of_[i] - 1])) is_excluded[i] = 0;
  }
  claims_ = FindClaims(is_excluded);
}

/// Votes on the objects that the frame shows connected, or apart.
void SegmentAssignment::Vote() {
  ExcludeContactsOfInstances();
  for (const Claim& claim : claims_) {
    const std::size_t owner = owner_of_[claim.segment];
    if (owner == 0 || owner == claim.place + 1 || segment_on_[claim.place] != 0) continue;
    TrackedObject* object = (*in_view_)[owner - 1].object;
    TrackedObject* other = (*in_view_)[claim.place].object;
    if (object->is_archived() || other->is_archived() || !IsOfObject(claim) ||
        object->state().class_id != other->state().class_id) {
      continue;
    }
    VoteOnParts(PartVote::kConnected, object, other, map_);
  }
  for (const auto& [pair, lines] : CountBorders()) {
    const std::size_t min_lines = parameters_.gaps.min_lines;
    if (lines.apart + lines.occluded < min_lines) continue;
    VoteOnParts(lines.apart < min_lines ? PartVote::kOccluded : PartVote::kApart,
                (*in_view_)[pair.first].object,
                (*in_view_)[pair.second].object,
                map_);
  }
}

/// Counts for pairs of objects with a segment the rows and columns of the image in which the frame
/// looks through a gap between them, or shows their border.
SegmentAssignment::BorderCounts SegmentAssignment::CountBorders() const {
  BorderCounts borders;
  const auto width = static_cast<std::size_t>(frame_.samples.width());
  const auto height = static_cast<std::size_t>(frame_.samples.height());
  for (std::size_t row = 0; row < height; ++row) CountBordersOn({row * width, 1, width}, &borders);
  for (std::size_t column = 0; column < width; ++column) {
    CountBordersOn({column, width, height}, &borders);
  }
  return borders;
}

/// Counts the borders on one row or column of samples.
void SegmentAssignment::CountBordersOn(const SampleLine& line, BorderCounts* borders) const {
  std::size_t last = 0;        // The last sample of an object.
  std::size_t last_owner = 0;  // 0: none yet.
  constexpr float kNothing = std::numeric_limits<float>::max();
  float nearest_m = kNothing;  // Between both.
  for (std::size_t i = 0; i < line.count; ++i) {
    const std::size_t index = line.first + i * line.step;
    const SurfaceSample& sample = frame_.samples[index];
    const std::size_t owner = segment_of_[index] == 0 ? 0 : owner_of_[segment_of_[index] - 1];
    if (owner == 0) {
      nearest_m = std::min(nearest_m, sample.is_valid() ? sample.depth_m : 0.0F);
      continue;
    }
    if (last_owner != 0 && owner != last_owner &&
        IsBorder(frame_.samples[last], sample, nearest_m)) {
      BorderCount& count =
          (*borders)[{std::min(owner, last_owner) - 1, std::max(owner, last_owner) - 1}];
      const bool is_occluded =
          nearest_m == kNothing && frame_.samples[last].instance == sample.instance;
      ++(is_occluded ? count.occluded : count.apart);
    }
    last = index;
    last_owner = owner;
    nearest_m = kNothing;
  }
}

/// True if two samples of different objects are near, and everything between them is farther away.
bool SegmentAssignment::IsBorder(const SurfaceSample& a,
                                 const SurfaceSample& b,
                                 float nearest_between_m) const {
  const double distance_m = (a.position_world - b.position_world).cast<double>().norm();
  if (distance_m > parameters_.gaps.max_width_m) return false;
  return nearest_between_m > std::max(a.depth_m, b.depth_m);
}

/// Gives the samples of each segment to its object, except those on the surface of another object
/// that it is connected with.
void SegmentAssignment::SetOwners() {
  for (std::size_t i = 0; i < frame_.segments.size(); ++i) {
    if (owner_of_[i] == 0) continue;
    for (const std::size_t index : frame_.segments[i].samples) {
      if (segment_of_[index] == 0) continue;
      association_.owner[index] = static_cast<std::uint32_t>(owner_of_[i]);
    }
  }
  const std::vector<char> is_on_owner = FindSamplesOnOwner();
  // The last one to take a sample keeps it: an object whose observed surface the sample is on
  // prevails over one that merely ends beside it.
  for (const bool is_observed : {false, true}) {
    for (const SampleOnObject& found : frame_.on_objects) {
      if (found.is_observed != is_observed || (*in_view_)[found.place].object->is_archived()) {
        continue;
      }
      if (is_on_owner[found.sample] == 0) GiveToConnected(found);
    }
  }
}

/// Gives a sample to the object whose surface it is on, if the sample is in no segment, or if its
/// segment connects the object with another one; not if the frame shows them as two instances.
void SegmentAssignment::GiveToConnected(const SampleOnObject& found) {
  if (IsOfOtherInstance(found)) return;
  const ClassId class_id = (*in_view_)[found.place].object->state().class_id;
  const std::uint32_t owner = association_.owner[found.sample];
  const SurfaceSample& sample = frame_.samples[found.sample];
  const bool is_unassigned = frame_.uses[found.sample] != SampleUse::kSegment &&
                             !IsLabelledBackground(config_, sample) &&
                             class_id.value() == sample.label;
  const bool is_connected = Association::IsObject(owner) && segment_on_[found.place] == 0 &&
                            (*in_view_)[owner - 1].object->state().class_id == class_id;
  if (!is_unassigned && !is_connected) return;
  association_.owner[found.sample] = static_cast<std::uint32_t>(found.place + 1);
}

/// True if a sample and the segment of the object whose surface it is on differ in their instance.
bool SegmentAssignment::IsOfOtherInstance(const SampleOnObject& found) const {
  if (segment_on_[found.place] == 0) return false;
  const std::uint16_t instance = frame_.segments[segment_on_[found.place] - 1].instance;
  const std::uint16_t of_sample = frame_.samples[found.sample].instance;
  return instance != 0 && of_sample != 0 && instance != of_sample;
}

/// Gives the surface that belongs to no object to the unsegmented surface of its class.
void SegmentAssignment::SetAside() {
  for (std::size_t index = 0; index < frame_.samples.size(); ++index) {
    const SurfaceSample& sample = frame_.samples[index];
    const ClassId class_id(sample.label);
    if (!sample.is_valid() || association_.owner[index] != Association::kNone ||
        frame_.uses[index] == SampleUse::kNone || IsLabelledBackground(config_, sample)) {
      continue;
    }
    segment_of_[index] = 0;
    association_.owner[index] =
        static_cast<std::uint32_t>(PlaceOfUnsegmented(class_id, sample) + 1);
  }
}

/// Returns the place of the unsegmented surface of a class; adds it if there is none in view.
std::size_t SegmentAssignment::PlaceOfUnsegmented(ClassId class_id, const SurfaceSample& sample) {
  const auto [entry, is_new] = unsegmented_.emplace(class_id, in_view_->size());
  if (is_new) {
    TrackedObject& object = map_->AddObject(sample.position_world.cast<double>());
    ObjectEdit edit = map_->Edit(&object);
    edit.state().class_id = class_id;
    edit.state().has_given_extent = true;
    edit.state().source = frame_.source;
    in_view_->push_back({&object, 0, frame_.samples.width(), 0, frame_.samples.height()});
  }
  return entry->second;
}

void SegmentAssignment::AddSegmentAsObject(std::size_t index) {
  const FrameSegment& segment = frame_.segments[index];
  if (segment.area_m2 < parameters_.min_new_area_m2 ||
      IsUnresolved(segment, parameters_.min_width_samples, frame_.samples))
    return;
  Eigen::Vector3d mean_world = Eigen::Vector3d::Zero();
  for (const std::size_t sample : segment.samples) {
    mean_world += frame_.samples[sample].position_world.cast<double>();
  }
  TrackedObject& object = map_->AddObject(mean_world / static_cast<double>(segment.samples.size()));
  ObjectEdit edit = map_->Edit(&object);
  edit.state().class_id = ClassId(segment.label);
  edit.state().has_given_extent = segment.instance != 0 || segment.label != kNoClass.value();
  edit.state().source = frame_.source;
  edit.state().belief = InitialBelief(identity_.initial_stationarity);
  AddInView(&object, index);
}

}  // namespace steadymap
