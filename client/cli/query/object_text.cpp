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

void WriteVectorJson(const char* key, const v1::Vector3& vector, JsonWriter* json) {
  json->Key(key).Vector(vector.x(), vector.y(), vector.z());
}

// Writes a pose as a member of the JSON object that is open.
void WritePoseJson(const char* key, const v1::UprightPose& pose, JsonWriter* json) {
  json->Key(key).BeginObject();
  WriteVectorJson("position", pose.position_m(), json);
  json->Key("yaw").Number(pose.yaw_rad());
  json->EndObject();
}

// Writes the members of a belief into the JSON object that is open.
void WriteBeliefMembers(const v1::Belief& belief, JsonWriter* json) {
  json->Key("stationarity").Number(StationarityOf(belief));
  json->Key("alpha").Number(belief.alpha());
  json->Key("beta").Number(belief.beta());
  json->Key("change_mean_m").Number(belief.change_mean_m());
  json->Key("change_std_m").Number(belief.change_std_m());
}

// Returns the part of an event's line after its type: the object or robot and the change.
std::string EventText(const v1::ObjectEvent& event, const ClassNames& classes) {
  if (!event.robot().empty()) return absl::StrCat("robot ", event.robot(), "/", event.sensor());
  if (event.object_id() == 0) return "";
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
         << TimeText(object.last_seen()) << '\n';
  }
}

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
                      object.revision());
}

void WriteObjectJson(const v1::Object& object, const ClassNames& classes, JsonWriter* json) {
  json->BeginObject();
  json->Key("id").Integer(object.id());
  json->Key("class").Integer(object.class_id());
  json->Key("class_name").Text(classes.NameOf(object.class_id()));
  json->Key("class_confidence").Number(object.class_confidence());
  json->Key("standing").Text(WordOf(v1::ObjectStanding_descriptor(), object.standing()));
  WriteVectorJson("center", object.cuboid().center_m(), json);
  json->Key("yaw").Number(object.cuboid().yaw_rad());
  WriteVectorJson("size", object.cuboid().size_m(), json);
  WriteBeliefMembers(object.belief(), json);
  json->Key("first_seen").Number(SecondsOf(object.first_seen()));
  json->Key("last_seen").Number(SecondsOf(object.last_seen()));
  json->Key("views").Integer(object.views());
  json->Key("absences").Integer(object.absences());
  json->Key("revision").Integer(object.revision());
  json->Key("leaves").Integer(object.leaves());
  json->EndObject();
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

void WriteEventJson(const v1::ObjectEvent& event, const ClassNames& classes, JsonWriter* json) {
  json->BeginObject();
  json->Key("number").Integer(event.number());
  json->Key("type").Text(WordOf(v1::EventType_descriptor(), event.type()));
  json->Key("reason").Text(WordOf(v1::EventReason_descriptor(), event.reason()));
  json->Key("object").Integer(event.object_id());
  json->Key("class").Integer(event.class_id());
  json->Key("class_name").Text(classes.NameOf(event.class_id()));
  json->Key("time").Number(SecondsOf(event.capture_time()));
  json->Key("revision").Integer(event.revision());
  WriteVectorJson("center", event.center_m(), json);
  if (event.has_old_center_m()) {
    WriteVectorJson("old_center", event.old_center_m(), json);
    WriteVectorJson("new_center", event.center_m(), json);
  }
  if (event.has_world_from_object_before() && event.has_world_from_object_after()) {
    WritePoseJson("pose_before", event.world_from_object_before(), json);
    WritePoseJson("pose_after", event.world_from_object_after(), json);
  }
  if (event.has_confidence()) json->Key("confidence").Number(event.confidence());
  if (event.related_object_id() != 0) json->Key("related").Integer(event.related_object_id());
  if (!event.robot().empty()) {
    json->Key("robot").Text(event.robot());
    json->Key("sensor").Text(event.sensor());
  }
  if (event.has_before() && event.has_after()) {
    json->Key("views").Integer(event.views());
    json->Key("absences").Integer(event.absences());
    json->Key("before").BeginObject();
    WriteBeliefMembers(event.before(), json);
    json->EndObject();
    json->Key("after").BeginObject();
    WriteBeliefMembers(event.after(), json);
    json->EndObject();
  }
  json->EndObject();
}

}  // namespace steadymap
