#include "client/cli/query/object_text.h"

#include <algorithm>
#include <charconv>
#include <iomanip>

#include <absl/strings/str_cat.h>

#include "client/cli/text/enumerator_text.h"
#include "client/cli/text/number_text.h"

namespace steadymap {
namespace {

std::string PointText(const v1::Vector3& point, int decimals) {
  return absl::StrCat("(",
                      FixedText(point.x(), decimals),
                      ", ",
                      FixedText(point.y(), decimals),
                      ", ",
                      FixedText(point.z(), decimals),
                      ")");
}

double StationarityOf(const v1::Belief& belief) {
  const double sum = belief.alpha() + belief.beta();
  return sum > 0.0 ? belief.alpha() / sum : 0.0;
}

Json PoseJson(const v1::UprightPose& pose) {
  return {{"position", PointJson(pose.position_m())}, {"yaw", pose.yaw_rad()}};
}

Json BeliefJson(const v1::Belief& belief) {
  return {{"stationarity", StationarityOf(belief)},
          {"alpha", belief.alpha()},
          {"beta", belief.beta()},
          {"change_mean_m", belief.change_mean_m()},
          {"change_std_m", belief.change_std_m()}};
}

Json ContradictionJson(const v1::Contradiction& contradiction) {
  return {{"present", {contradiction.present_robot(), contradiction.present_sensor()}},
          {"absent", {contradiction.absent_robot(), contradiction.absent_sensor()}},
          {"since", SecondsOf(contradiction.since())},
          {"last", SecondsOf(contradiction.last())},
          {"sessions", contradiction.sessions()}};
}

// Returns the part of an event's line after its type: the object or robot and the change.
std::string EventText(const v1::ObjectEvent& event, const ClassNames& classes) {
  const std::string sensor = absl::StrCat(event.robot(), "/", event.sensor());
  if (event.object_id() == 0) return event.robot().empty() ? "" : absl::StrCat("robot ", sensor);
  std::string text =
      absl::StrCat("object ", event.object_id(), " (", classes.NameOf(event.class_id()), ")");
  if (event.has_old_center_m()) {
    absl::StrAppend(&text, " from ", PointText(event.old_center_m(), 2), " to ");
  } else {
    absl::StrAppend(&text, " at ");
  }
  absl::StrAppend(&text, PointText(event.center_m(), 2));
  if (event.has_confidence()) {
    absl::StrAppend(&text, ", confidence ", FixedText(event.confidence(), 2));
  }
  if (event.related_object_id() != 0) {
    absl::StrAppend(&text, ", related to object ", event.related_object_id());
  }
  if (!event.robot().empty()) absl::StrAppend(&text, ", gone for robot ", sensor);
  absl::StrAppend(&text,
                  ", E[v] ",
                  FixedText(StationarityOf(event.before()), 2),
                  " -> ",
                  FixedText(StationarityOf(event.after()), 2));
  return text;
}

}  // namespace

ClassNames::ClassNames(const v1::MapConfig& config) {
  for (const v1::SemanticClass& row : config.classes()) names_[row.id()] = row.name();
}

std::string ClassNames::NameOf(std::uint32_t class_id) const {
  const auto found = names_.find(class_id);
  return found != names_.end() ? found->second : absl::StrCat("class ", class_id);
}

absl::StatusOr<ClassId> ClassNames::Parse(const std::string& text) const {
  for (const auto& [id, name] : names_) {
    if (name == text) return ClassId(static_cast<std::uint16_t>(id));
  }
  std::uint16_t id = 0;
  const char* const end = text.data() + text.size();
  const std::from_chars_result parsed = std::from_chars(text.data(), end, id);
  if (parsed.ec == std::errc() && parsed.ptr == end) return ClassId(id);
  return absl::InvalidArgumentError(
      absl::StrCat("expected the name or the id of one of the map's classes, got \"", text, "\""));
}

absl::StatusOr<std::vector<ClassId>> ClassNames::ParseAll(
    const std::vector<std::string>& texts) const {
  std::vector<ClassId> classes;
  for (const std::string& text : texts) {
    const absl::StatusOr<ClassId> class_id = Parse(text);
    if (!class_id.ok()) return class_id.status();
    classes.push_back(*class_id);
  }
  return classes;
}

absl::StatusOr<v1::EventType> ParseEventType(std::string_view text) {
  const int type = NumberOf(v1::EventType_descriptor(), text);
  if (type != 0) return static_cast<v1::EventType>(type);
  return absl::InvalidArgumentError(absl::StrCat("expected an event type (",
                                                 WordsOf(v1::EventType_descriptor()),
                                                 "), got \"",
                                                 std::string(text),
                                                 "\""));
}

void WriteObjectTable(const std::vector<v1::Object>& objects,
                      const ClassNames& classes,
                      std::ostream* out) {
  std::size_t width = 5;
  for (const v1::Object& object : objects) {
    width = std::max(width, classes.NameOf(object.class_id()).size());
  }
  const int class_width = static_cast<int>(width) + 2;
  *out << std::right << std::setw(6) << "ID"
       << "  " << std::left << std::setw(class_width) << "CLASS" << std::setw(24) << "CENTRE [m]"
       << std::setw(21) << "SIZE [m]" << std::setw(7) << "E[v]" << std::setw(7) << "VIEWS"
       << std::setw(11) << "STANDING"
       << "LAST SEEN\n";
  for (const v1::Object& object : objects) {
    *out << std::right << std::setw(6) << object.id() << "  " << std::left << std::setw(class_width)
         << classes.NameOf(object.class_id()) << std::setw(24)
         << PointText(object.cuboid().center_m(), 2) << std::setw(21)
         << PointText(object.cuboid().size_m(), 2) << std::setw(7)
         << FixedText(object.stationarity(), 2) << std::setw(7) << object.views() << std::setw(11)
         << WordOf(v1::ObjectStanding_descriptor(), object.standing())
         << TimeText(object.last_seen())
         << (object.contradictions().empty() ? "" : "  contradicted") << '\n';
  }
}

Json PointJson(const v1::Vector3& point) { return VectorJson(point.x(), point.y(), point.z()); }

double SecondsOf(const google::protobuf::Timestamp& moment) {
  return static_cast<double>(moment.seconds()) + static_cast<double>(moment.nanos()) * 1e-9;
}

std::string ObjectText(const v1::Object& object, const ClassNames& classes) {
  return absl::StrCat("object ",
                      object.id(),
                      " (",
                      classes.NameOf(object.class_id()),
                      ") ",
                      WordOf(v1::ObjectStanding_descriptor(), object.standing()),
                      " at ",
                      PointText(object.cuboid().center_m(), 2),
                      ", size ",
                      PointText(object.cuboid().size_m(), 2),
                      ", E[v] ",
                      FixedText(object.stationarity(), 2),
                      ", ",
                      CountText(object.views()),
                      " views, revision ",
                      object.revision(),
                      object.contradictions().empty() ? "" : ", contradicted");
}

Json ObjectJson(const v1::Object& object, const ClassNames& classes) {
  Json json = {{"id", object.id()},
               {"class", object.class_id()},
               {"class_name", classes.NameOf(object.class_id())},
               {"class_confidence", object.class_confidence()},
               {"standing", WordOf(v1::ObjectStanding_descriptor(), object.standing())},
               {"center", PointJson(object.cuboid().center_m())},
               {"yaw", object.cuboid().yaw_rad()},
               {"size", PointJson(object.cuboid().size_m())}};
  json.update(BeliefJson(object.belief()));
  json["first_seen"] = SecondsOf(object.first_seen());
  json["last_seen"] = SecondsOf(object.last_seen());
  json["views"] = object.views();
  json["absences"] = object.absences();
  json["revision"] = object.revision();
  json["leaves"] = object.leaves();
  json["contradictions"] = Json::array();
  for (const v1::Contradiction& entry : object.contradictions()) {
    json["contradictions"].push_back(ContradictionJson(entry));
  }
  return json;
}

void WriteEventLines(const std::vector<v1::ObjectEvent>& events,
                     const ClassNames& classes,
                     std::ostream* out) {
  for (const v1::ObjectEvent& event : events) {
    *out << std::right << std::setw(6) << event.number() << "  " << TimeText(event.capture_time())
         << "  revision " << event.revision() << "  "
         << WordOf(v1::EventType_descriptor(), event.type()) << " ("
         << WordOf(v1::EventReason_descriptor(), event.reason()) << ")  "
         << EventText(event, classes) << '\n';
  }
}

Json EventJson(const v1::ObjectEvent& event, const ClassNames& classes) {
  Json json = {{"number", event.number()},
               {"type", WordOf(v1::EventType_descriptor(), event.type())},
               {"reason", WordOf(v1::EventReason_descriptor(), event.reason())},
               {"object", event.object_id()},
               {"class", event.class_id()},
               {"class_name", classes.NameOf(event.class_id())},
               {"time", SecondsOf(event.capture_time())},
               {"revision", event.revision()},
               {"center", PointJson(event.center_m())}};
  if (event.has_old_center_m()) {
    json["old_center"] = PointJson(event.old_center_m());
    json["new_center"] = PointJson(event.center_m());
  }
  if (event.has_world_from_object_before() && event.has_world_from_object_after()) {
    json["pose_before"] = PoseJson(event.world_from_object_before());
    json["pose_after"] = PoseJson(event.world_from_object_after());
  }
  if (event.has_confidence()) json["confidence"] = event.confidence();
  if (event.related_object_id() != 0) json["related"] = event.related_object_id();
  if (!event.robot().empty()) {
    json["robot"] = event.robot();
    json["sensor"] = event.sensor();
  }
  if (event.has_before() && event.has_after()) {
    json["views"] = event.views();
    json["absences"] = event.absences();
    json["before"] = BeliefJson(event.before());
    json["after"] = BeliefJson(event.after());
  }
  return json;
}

}  // namespace steadymap
