#include "core/map_updater.h"

#include "core/object_mapper.h"
#include "core/tsdf_integrator.h"

namespace steadymap {
namespace {

/// The `static` policy: every frame is fused, nothing is ever removed.
class StaticUpdater final : public MapUpdater {
 public:
  explicit StaticUpdater(const MapConfig& config) : integrator_(config) {}

  void Process(const Frame& /*frame*/, SemanticCloud* cloud, WorkingMap* map) override {
    map->FuseBackground(*cloud, &integrator_);
  }

 private:
  TsdfIntegrator integrator_;
};

}  // namespace

std::unique_ptr<MapUpdater> MakeMapUpdater(const MapConfig& config) {
  switch (config.policy) {
    case UpdatePolicy::kStatic:
      return std::make_unique<StaticUpdater>(config);
    case UpdatePolicy::kPocd:
      return std::make_unique<ObjectMapper>(config, ObjectMapperParameters{});
  }
  return nullptr;
}

}  // namespace steadymap
