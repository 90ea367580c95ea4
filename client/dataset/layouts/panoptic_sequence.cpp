#include "client/dataset/layouts/panoptic_sequence.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <absl/strings/numbers.h>
#include <absl/strings/str_split.h>

#include "client/dataset/files/depth_file.h"
#include "client/dataset/files/folder_listing.h"
#include "client/dataset/files/text_file.h"
#include "client/dataset/layouts/segment_classes.h"

namespace steadymap {
namespace {

namespace fs = std::filesystem;

// The camera with which the flat was rendered.
constexpr PinholeCamera kFlatCamera = {640, 480, 320.0, 320.0, 320.0, 240.0};
constexpr double kMaxNanoseconds = 9e18;

struct Entry {
  std::string id;
  Timestamp time;
};

// File names start with the id, so it must not contain characters that lead out of the folder.
bool IsId(std::string_view text) {
  return !text.empty() && text.find_first_of("/\\.") == std::string_view::npos;
}

// Parses integer nanoseconds. Some recordings write them with a fraction or an exponent.
std::optional<Timestamp> TimeOf(const std::string& text) {
  std::int64_t ns = 0;
  if (absl::SimpleAtoi(text, &ns) && ns >= 0) return Timestamp::FromNanoseconds(ns);
  double number = 0.0;
  const bool is_time = absl::SimpleAtod(text, &number) && number >= 0 && number <= kMaxNanoseconds;
  return is_time ? std::make_optional(Timestamp::FromNanoseconds(std::llround(number)))
                 : std::nullopt;
}

// Reads `timestamps.csv`, with or without a header, and sorts the entries by time.
absl::StatusOr<std::vector<Entry>> ReadEntries(const fs::path& file) {
  const absl::StatusOr<std::vector<TextLine>> lines = ReadTextLines(file);
  if (!lines.ok()) return lines.status();
  std::vector<Entry> entries;
  for (const TextLine& line : *lines) {
    const std::vector<std::string> cells =
        absl::StrSplit(line.text, absl::ByAnyChar(", \t"), absl::SkipEmpty());
    if (&line == &lines->front() && !cells.empty() && cells[0] == "ImageID") continue;
    const std::optional<Timestamp> time = cells.size() == 2 ? TimeOf(cells[1]) : std::nullopt;
    if (!time || !IsId(cells[0])) return MalformedLine(file, line, "\"ImageID, nanoseconds\"");
    entries.push_back({cells[0], *time});
  }
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.time < b.time;
  });
  return entries;
}

// Returns `groundtruth_labels.csv` in the folder of the run or in its parent; empty if there is
// none.
fs::path ClassTableOf(const fs::path& folder) {
  constexpr char kName[] = "groundtruth_labels.csv";
  fs::path table = FindEntry(folder, kName);
  // `folder / ".."` is used because `parent_path()` of "run1/" or "." is not the parent folder.
  return !table.empty() ? table : FindEntry(folder / "..", kName);
}

// Returns the file of a frame and kind; empty if there is none.
fs::path FileOf(const fs::path& folder, const std::string& id, const char* kind) {
  fs::path file = folder / (id + kind);
  std::error_code error;
  return fs::exists(file, error) ? file : fs::path();
}

// Uses the ground truth if its classes are known, otherwise the prediction if its classes are
// known, otherwise only the instances.
void AddSegments(const fs::path& folder,
                 const std::string& id,
                 const fs::path& class_table,
                 RecordedFrame* frame) {
  const fs::path truth = FileOf(folder, id, "_segmentation.png");
  const fs::path predicted = FileOf(folder, id, "_predicted.png");
  const fs::path predicted_classes = FileOf(folder, id, "_labels.json");
  frame->instances = truth.empty() ? predicted : truth;
  if (!truth.empty() && !class_table.empty()) {
    frame->labels = truth;
    frame->segment_classes = class_table;
  } else if (!predicted.empty() && !predicted_classes.empty()) {
    frame->labels = predicted;
    frame->segment_classes = predicted_classes;
  }
}

bool IsPanopticSequence(const fs::path& folder) {
  return !FindEntry(folder, "timestamps.csv").empty();
}

absl::StatusOr<RecordedSequence> IndexPanopticSequence(const fs::path& folder) {
  const auto entries = ReadEntries(FindEntry(folder, "timestamps.csv"));
  if (!entries.ok()) return entries.status();
  const fs::path class_table = ClassTableOf(folder);
  if (!class_table.empty()) {
    const absl::Status status = SegmentClasses::Load(class_table).status();
    if (!status.ok()) return status;
  }
  RecordedSequence sequence;
  sequence.camera = kFlatCamera;
  sequence.metres_per_unit = kMetresPerUnitOfFloatDepth;
  for (const Entry& entry : *entries) {
    const fs::path pose_file = FileOf(folder, entry.id, "_pose.txt");
    RecordedFrame frame;
    if (!pose_file.empty()) frame.T_dataset_camera = ReadTransform(pose_file);
    const bool is_lost =
        frame.T_dataset_camera.ok() && !frame.T_dataset_camera->matrix().allFinite();
    if (pose_file.empty() || is_lost) {
      ++sequence.skipped_count;
      continue;
    }
    frame.time = entry.time;
    frame.depth = folder / (entry.id + "_depth.tiff");
    frame.color = FileOf(folder, entry.id, "_color.png");
    AddSegments(folder, entry.id, class_table, &frame);
    sequence.frames.push_back(std::move(frame));
  }
  return sequence;
}

}  // namespace

DatasetFormat PanopticFormat() {
  return {"panoptic",
          "timestamps.csv and files ID_depth.tiff, ID_pose.txt",
          IsPanopticSequence,
          IndexPanopticSequence,
          /*has_depth_unit=*/false};
}

}  // namespace steadymap
