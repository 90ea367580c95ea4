#include "client/map/map_mirror.h"

#include <optional>
#include <utility>

#include <absl/base/thread_annotations.h>
#include <absl/strings/str_cat.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include "client/map/mirror_assembly.h"

namespace steadymap {
namespace {

/// Returns `options` with patches enabled if the mirror will hold the leaves to patch.
MirrorOptions WithPatches(MirrorOptions options) {
  options.takes_patches = options.start == WatchOpening::kSnapshot;
  return options;
}

}  // namespace

/// Builds the map from the content of the watch and publishes it.
class MapMirror::Follower final : public WatchConsumer {
 public:
  explicit Follower(MirrorCallbacks callbacks) : callbacks_(std::move(callbacks)) {}

  absl::Status Begin(const v1::WatchCreated& created, WatchOpening opening) override
      ABSL_LOCKS_EXCLUDED(mutex_) {
    scale_ = {created.voxel_size_m(), created.truncation_m()};
    if (opening == WatchOpening::kSnapshot) {
      ExpectSnapshot();
      return absl::OkStatus();
    }
    if (opening == WatchOpening::kResume && has_begun_) return absl::OkStatus();
    auto empty = std::make_shared<MapSnapshot>(scale_);
    empty->revision = Revision(created.revision());
    Show(std::move(empty), {});
    return absl::OkStatus();
  }

  absl::Status Resync(const v1::WatchResync&) override {
    ExpectSnapshot();
    return absl::OkStatus();
  }

  absl::Status TakeSnapshot(const v1::SnapshotChunk& chunk) override {
    return Assembly().TakeSnapshot(chunk);
  }

  absl::Status TakeDelta(const v1::DeltaFragment& delta) override {
    return Assembly().TakeDelta(delta);
  }

  absl::Status TakeEvents(const v1::EventBatch& batch) override {
    return Assembly().TakeEvents(batch);
  }

  void Commit(const WatchStep& step) override ABSL_LOCKS_EXCLUDED(mutex_) {
    if (!step.IsNews()) {
      const absl::MutexLock lock(&mutex_);
      resume_token_ = step.resume_token;
      return;
    }
    const MirrorStep whole = Assembly().Finish(step);
    Discard();
    Show(whole.map, step.resume_token);
    if (callbacks_.on_step) callbacks_.on_step(whole);
    if (callbacks_.on_events && !whole.events.empty()) callbacks_.on_events(whole.events);
  }

  void Discard() override {
    assembly_.reset();
    expects_snapshot_ = false;
  }

  void OnState(const WatchStateChange& change) override ABSL_LOCKS_EXCLUDED(mutex_) {
    if (change.state == WatchState::kEnded) {
      const absl::MutexLock lock(&mutex_);
      end_status_ = change.status;
    }
    if (callbacks_.on_state) callbacks_.on_state(change);
  }

  std::shared_ptr<const MapSnapshot> snapshot() const ABSL_LOCKS_EXCLUDED(mutex_) {
    const absl::MutexLock lock(&mutex_);
    return shown_;
  }

  std::string resume_token() const ABSL_LOCKS_EXCLUDED(mutex_) {
    const absl::MutexLock lock(&mutex_);
    return resume_token_;
  }

  absl::Status status() const ABSL_LOCKS_EXCLUDED(mutex_) {
    const absl::MutexLock lock(&mutex_);
    return end_status_;
  }

  absl::Status AwaitRevision(Revision revision, std::chrono::milliseconds timeout) const
      ABSL_LOCKS_EXCLUDED(mutex_) {
    const absl::MutexLock lock(&mutex_);
    const auto is_over = [this, revision]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return shown_->revision >= revision || !end_status_.ok();
    };
    mutex_.AwaitWithTimeout(absl::Condition(&is_over), absl::FromChrono(timeout));
    if (shown_->revision >= revision) return absl::OkStatus();
    if (!end_status_.ok()) return end_status_;
    return absl::DeadlineExceededError(absl::StrCat("the mirror did not reach revision ",
                                                    revision.value(),
                                                    " within ",
                                                    timeout.count(),
                                                    " ms; it is at revision ",
                                                    shown_->revision.value()));
  }

 private:
  void ExpectSnapshot() {
    Discard();
    expects_snapshot_ = true;
  }

  /// Returns the assembly of the current step; begins it if needed.
  MirrorAssembly& Assembly() {
    if (!assembly_) assembly_.emplace(expects_snapshot_ ? MapSnapshot(scale_) : *snapshot());
    return *assembly_;
  }

  void Show(std::shared_ptr<const MapSnapshot> map, const std::string& token)
      ABSL_LOCKS_EXCLUDED(mutex_) {
    has_begun_ = true;
    const absl::MutexLock lock(&mutex_);
    // The previous map is destroyed after the mutex is released.
    shown_.swap(map);
    resume_token_ = token;
  }

  const MirrorCallbacks callbacks_;

  // Used by the watch's thread only.
  VoxelScale scale_;
  bool has_begun_ = false;         ///< A map to continue from exists.
  bool expects_snapshot_ = false;  ///< The next step replaces the map.
  std::optional<MirrorAssembly> assembly_;

  mutable absl::Mutex mutex_;
  std::shared_ptr<const MapSnapshot> shown_ ABSL_GUARDED_BY(mutex_) =
      std::make_shared<const MapSnapshot>();
  std::string resume_token_ ABSL_GUARDED_BY(mutex_);
  absl::Status end_status_ ABSL_GUARDED_BY(mutex_);
};

std::unique_ptr<MapMirror> MapMirror::Start(ChannelOpener open_channel,
                                            const MapName& map,
                                            const MirrorOptions& options,
                                            const MirrorCallbacks& callbacks) {
  return std::unique_ptr<MapMirror>(
      new MapMirror(std::move(open_channel), map, options, callbacks));
}

MapMirror::MapMirror(ChannelOpener open_channel,
                     const MapName& map,
                     const MirrorOptions& options,
                     const MirrorCallbacks& callbacks)
    : follower_(std::make_unique<Follower>(callbacks)),
      watch_(std::make_unique<MapWatch>(
          std::move(open_channel), map, WithPatches(options), follower_.get())) {}

MapMirror::~MapMirror() = default;

std::shared_ptr<const MapSnapshot> MapMirror::snapshot() const { return follower_->snapshot(); }

std::string MapMirror::resume_token() const { return follower_->resume_token(); }

absl::Status MapMirror::status() const { return follower_->status(); }

absl::Status MapMirror::AwaitRevision(Revision revision, std::chrono::milliseconds timeout) const {
  return follower_->AwaitRevision(revision, timeout);
}

std::vector<MapDistance> MapMirror::SampleDistance(
    std::span<const Eigen::Vector3d> points_world) const {
  const std::shared_ptr<const MapSnapshot> map = snapshot();
  MapSampler sampler(*map);
  std::vector<MapDistance> distances;
  distances.reserve(points_world.size());
  for (const Eigen::Vector3d& point_world : points_world) {
    distances.push_back(sampler.Sample(point_world));
  }
  return distances;
}

std::vector<MapRayHit> MapMirror::CastRays(std::span<const WorldRay> rays,
                                           double max_range_m) const {
  const std::shared_ptr<const MapSnapshot> map = snapshot();
  MapSampler sampler(*map);
  std::vector<MapRayHit> hits;
  hits.reserve(rays.size());
  for (const WorldRay& ray : rays) {
    const Eigen::Vector3d direction = ray.direction_world.stableNormalized();
    const bool has_direction = direction.allFinite() && !direction.isZero();
    hits.push_back(has_direction && ray.origin_world.allFinite()
                       ? sampler.CastRay(ray.origin_world, direction, max_range_m)
                       : MapRayHit());
  }
  return hits;
}

std::vector<std::shared_ptr<const MapObject>> MapMirror::Objects() const {
  const std::shared_ptr<const MapSnapshot> map = snapshot();
  std::vector<std::shared_ptr<const MapObject>> objects;
  objects.reserve(map->objects.size());
  for (const auto& [id, object] : map->objects) objects.push_back(object);
  return objects;
}

}  // namespace steadymap
