#include "core/types/map_config.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <set>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "core/types/policy_parameters.h"

namespace steadymap {
namespace {

constexpr double kMinVoxelSizeM = 0.001;
constexpr double kMaxVoxelSizeM = 1.0;
constexpr double kMinTruncationVoxels = 2.0;
constexpr double kMaxTruncationVoxels = 16.0;
constexpr double kDefaultTruncationVoxels = 3.0;
constexpr double kMinMaxDepthM = 0.1;
constexpr double kMaxMaxDepthM = 100.0;
constexpr double kMaxMaxDepthVoxels = 4000.0;
constexpr std::size_t kMaxClassNameLength = 64;
constexpr std::size_t kMaxParameterNameShown = 64;

// In floating point, 0.15 / 0.05 is slightly below 3. Limits in voxels must not depend on the last
// bit.
constexpr double kRelativeSlack = 1e-9;

// The trailers of a call limit the length of an error message.
constexpr int kMostViolationsShown = 10;

/// Collects violations. The status has the field of the first violation.
class Violations {
 public:
  void Add(std::string field, const std::string& text) {
    if (first_field_.empty()) first_field_ = std::move(field);
    if (++count_ > kMostViolationsShown) return;
    absl::StrAppend(&message_, message_.empty() ? "" : "; ", text);
  }

  /// Adds a violation and returns false unless `value` lies in [`low`, `high`]; NaN does not.
  bool CheckRange(const char* field, double value, double low, double high) {
    if (value >= low * (1 - kRelativeSlack) && value <= high * (1 + kRelativeSlack)) return true;
    Add(field, absl::StrCat(field, " must lie in [", low, ", ", high, "], got ", value));
    return false;
  }

  absl::Status ToStatus() const {
    if (message_.empty()) return absl::OkStatus();
    const int more = count_ - kMostViolationsShown;
    return InvalidField(reason::kBadValue,
                        first_field_,
                        more > 0 ? absl::StrCat(message_, "; and ", more, " more") : message_);
  }

 private:
  std::string first_field_;
  std::string message_;
  int count_ = 0;
};

void CheckClasses(const std::vector<SemanticClass>& classes, Violations* violations) {
  if (classes.empty()) violations->Add("classes", "classes must not be empty");
  std::set<ClassId> seen;
  for (std::size_t i = 0; i < classes.size(); ++i) {
    const std::string field = absl::StrCat("classes[", i, "]");
    if (!seen.insert(classes[i].id).second) {
      violations->Add(field + ".id",
                      absl::StrCat(field, ".id ", classes[i].id.value(), " is a duplicate"));
    }
    if (classes[i].name.empty() || classes[i].name.size() > kMaxClassNameLength) {
      violations->Add(field + ".name",
                      absl::StrCat(field,
                                   ".name must have 1 to ",
                                   kMaxClassNameLength,
                                   " bytes, got ",
                                   classes[i].name.size()));
    }
  }
}

void CheckParameter(UpdatePolicy policy,
                    const std::string& name,
                    double value,
                    Violations* violations) {
  // A name may be as long as a message.
  const std::string field = "parameters[" + name.substr(0, kMaxParameterNameShown) + "]";
  const PolicyParameter* parameter = FindParameter(policy, name);
  if (parameter == nullptr) {
    violations->Add(
        field,
        absl::StrCat(
            field, " is not a parameter of the policy, which has: ", ParameterNames(policy)));
  } else if (violations->CheckRange(field.c_str(), value, parameter->min, parameter->max) &&
             parameter->is_whole && value != std::floor(value)) {
    violations->Add(field, absl::StrCat(field, " must be a whole number, got ", value));
  }
}

}  // namespace

std::vector<SemanticClass> TorwicClasses() {
  using enum ClassMotion;
  std::vector<SemanticClass> classes;
  const auto add = [&classes](const char* name, ClassMotion motion, bool in_background = false) {
    classes.push_back(
        {ClassId(static_cast<std::uint16_t>(classes.size())), name, motion, in_background});
  };
  add("background", kStatic, /*in_background=*/true);
  add("driveable ground", kStatic, /*in_background=*/true);
  add("ceiling", kStatic, /*in_background=*/true);
  add("ego vehicle", kDynamic);
  add("wall/fence/pillar", kStatic);
  add("misc static feature", kStatic);
  add("rack/shelf", kStatic);
  add("goods materials", kSemiStatic);
  add("fixed machinery", kStatic);
  add("cart/pallet jack", kSemiStatic);
  add("pylons", kSemiStatic);
  add("text region", kStatic);
  add("misc non-static feature", kSemiStatic);
  add("person", kDynamic);
  add("forklift/truck", kDynamic);
  add("misc dynamic feature", kDynamic);
  return classes;
}

double DefaultTruncationM(double voxel_size_m) {
  // 3 * 0.05 is slightly above 0.15 in binary, and clients display the value.
  return std::round(kDefaultTruncationVoxels * voxel_size_m * 1e6) / 1e6;
}

std::size_t MapConfig::label_limit() const {
  std::size_t limit = 1;
  for (const SemanticClass& row : classes) {
    limit = std::max(limit, static_cast<std::size_t>(row.id.value()) + 1);
  }
  return limit;
}

KnownLabels::KnownLabels(const std::vector<SemanticClass>& classes) : is_known_(1, true) {
  for (const SemanticClass& row : classes) {
    if (row.id.value() >= is_known_.size()) is_known_.resize(std::size_t{row.id.value()} + 1);
    is_known_[row.id.value()] = true;
  }
  is_dense_ = std::find(is_known_.begin(), is_known_.end(), false) == is_known_.end();
}

const SemanticClass* MapConfig::FindClass(ClassId id) const {
  const auto row = std::find_if(
      classes.begin(), classes.end(), [id](const SemanticClass& known) { return known.id == id; });
  return row == classes.end() ? nullptr : &*row;
}

bool MapConfig::IsInBackground(ClassId id) const {
  const SemanticClass* row = FindClass(id);
  return row == nullptr || row->in_background;
}

absl::Status ValidateMapConfig(const MapConfig& config) {
  Violations violations;
  // An invalid voxel size gives no valid limits for the truncation distance.
  if (violations.CheckRange("voxel_size_m", config.voxel_size_m, kMinVoxelSizeM, kMaxVoxelSizeM)) {
    violations.CheckRange("truncation_m",
                          config.truncation_m,
                          kMinTruncationVoxels * config.voxel_size_m,
                          kMaxTruncationVoxels * config.voxel_size_m);
  }
  if (violations.CheckRange("max_depth_m", config.max_depth_m, kMinMaxDepthM, kMaxMaxDepthM) &&
      config.max_depth_m > kMaxMaxDepthVoxels * config.voxel_size_m * (1 + kRelativeSlack)) {
    violations.Add("max_depth_m",
                   absl::StrCat("max_depth_m must be at most ",
                                kMaxMaxDepthVoxels,
                                " voxels, ",
                                kMaxMaxDepthVoxels * config.voxel_size_m,
                                " m, got ",
                                config.max_depth_m));
  }
  CheckClasses(config.classes, &violations);
  for (const auto& [name, value] : config.parameters) {
    CheckParameter(config.policy, name, value, &violations);
  }
  return violations.ToStatus();
}

std::vector<std::string> RemoveInvalidParameters(MapConfig* config) {
  std::vector<std::string> removed;
  for (const auto& [name, value] : config->parameters) {
    Violations violations;
    CheckParameter(config->policy, name, value, &violations);
    if (!violations.ToStatus().ok()) removed.push_back(name);
  }
  for (const std::string& name : removed) config->parameters.erase(name);
  return removed;
}

}  // namespace steadymap
