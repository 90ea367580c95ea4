#include "client/cli/upload/upload_run.h"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "client/cli/maps/map_lookup.h"
#include "client/cli/text/argument_text.h"
#include "client/cli/text/json_text.h"
#include "client/cli/text/number_text.h"
#include "client/cli/upload/progress_report.h"
#include "client/cli/upload/upload_warnings.h"
#include "client/map/map_client.h"
#include "client/upload/frame_replay.h"
#include "client/upload/uploader.h"
#include "core/types/error.h"
#include "proto/convert_map.h"

namespace steadymap {
namespace {

absl::Status CheckId(const char* what, const std::string& id) {
  if (IsValidId(id)) return absl::OkStatus();
  return absl::InvalidArgumentError(std::string("expected a ") + what +
                                    " id: lower-case letters, digits and hyphens, starting with a "
                                    "letter, at most 63 characters; got \"" +
                                    id + "\"");
}

absl::Status NoSuchMap(const MapName& name) {
  return MakeError(absl::StatusCode::kNotFound,
                   reason::kNotFound,
                   "there is no map " + name.ToString() +
                       "; to create it, give a policy, such as --policy static or --policy "
                       "pocd, or run: steadymap map create " +
                       (name.tenant == "default" ? name.map : name.ToString()));
}

absl::StatusOr<UpdatePolicy> PolicyOfExistingMap(const v1::Map& map,
                                                 const MapConfig& wanted,
                                                 const MapOptions& options) {
  if (absl::Status status = CheckExistingMap(options, wanted, map); !status.ok()) return status;
  // A newer server may have other policies, whose use of frames is unknown here.
  return FromProto(map.config().policy()).value_or(UpdatePolicy::kStatic);
}

// Ensures that the map exists and agrees with the options, and returns its policy. The
// configuration of a map cannot be changed later, so the map is created only if the user has given
// a policy.
absl::StatusOr<UpdatePolicy> EnsureMap(const MapName& name,
                                       const UploadRunOptions& options,
                                       CommandContext* context) {
  const absl::StatusOr<MapConfig> config = ConfigOf(options.new_map);
  if (!config.ok()) return config.status();
  const absl::StatusOr<v1::Map> present = LookUpMap(name, RetryTime(options.retry_for_s), context);
  if (present.ok()) return PolicyOfExistingMap(*present, *config, options.new_map);
  if (present.status().code() != absl::StatusCode::kNotFound) return present.status();
  if (!options.new_map.policy) return NoSuchMap(name);
  MapClient client(context->Channel());
  absl::StatusOr<v1::Map> created = client.CreateMap(name, ToProto(*config));
  if (created.status().code() == absl::StatusCode::kAlreadyExists) {
    created = client.GetMap(name);
    if (created.ok()) return PolicyOfExistingMap(*created, *config, options.new_map);
  }
  if (!created.ok()) return created.status();
  context->err << "created " << created->name() << " with the policy " << *options.new_map.policy
               << ", " << LengthText(config->voxel_size_m) << " voxels and "
               << LengthText(config->truncation_m) << " truncation" << std::endl;
  return config->policy;
}

UploaderOptions OptionsOfUploader(const UploadRunOptions& options,
                                  FrameReplay* frames,
                                  ProgressReport* report) {
  UploaderOptions uploader;
  uploader.robot = options.source.robot;
  uploader.sensor = options.source.sensor;
  uploader.session = options.session;
  uploader.backoff.give_up_after = RetryTime(options.retry_for_s);
  uploader.on_progress = [report](const UploadProgress& progress) {
    report->Update(progress.integrated, progress.durable + progress.refused, progress.refused);
  };
  uploader.on_refused = [report](const RefusedUpload& refused) {
    report->AddRefusalReason(ReasonOf(refused.status));
  };
  uploader.on_retry = [report](const absl::Status& status, std::chrono::milliseconds delay) {
    report->Note("the upload was interrupted (" + std::string(status.message()) +
                 "); retrying in " + DurationText(1e-3 * static_cast<double>(delay.count())));
  };
  uploader.read_again = [frames](std::uint64_t client_seq) {
    return frames->ReadPushed(client_seq);
  };
  uploader.on_lost = [report](const LostFrames& lost) {
    report->Note(
        "warning: the server lost the frames " + std::to_string(lost.first) + " to " +
        std::to_string(lost.last) +
        ", which it had acknowledged; its data were probably restored from an older copy; sending "
        "these frames again");
  };
  return uploader;
}

struct UploadOutcome {
  std::string map;
  std::string session;
  UploadSummary summary;
  std::vector<UnreadableFrame> unreadable;
  double elapsed_s = 0.0;

  double frames_per_s() const {
    const auto frames = static_cast<double>(summary.progress.integrated);
    return elapsed_s > 0.0 ? frames / elapsed_s : 0.0;
  }
};

void WriteSummaryText(const UploadOutcome& outcome, std::ostream* out) {
  const UploadProgress& progress = outcome.summary.progress;
  *out << CountText(progress.integrated) << " frames integrated in "
       << DurationText(outcome.elapsed_s) << ", " << FixedText(outcome.frames_per_s(), 1)
       << " frames/s, " << BytesText(progress.bytes_sent) << " sent, "
       << CountText(progress.refused) << " refused, " << CountText(outcome.unreadable.size())
       << " unreadable; " << outcome.map << " is at revision " << progress.revision << '\n';
}

Json SummaryJson(const UploadOutcome& outcome) {
  const UploadProgress& progress = outcome.summary.progress;
  Json refused_frames = Json::array();
  for (const RefusedUpload& refused : outcome.summary.refused) {
    refused_frames.push_back({{"client_seq", refused.client_seq},
                              {"reason", ReasonOf(refused.status)},
                              {"field", FieldOf(refused.status)},
                              {"message", std::string(refused.status.message())}});
  }
  return {{"map", outcome.map},
          {"session", outcome.session},
          {"frames", progress.pushed},
          {"integrated", progress.integrated},
          {"refused", std::move(refused_frames)},
          {"refused_count", progress.refused},
          {"unreadable_count", outcome.unreadable.size()},
          {"sent_again", progress.sent_again},
          {"reconnections", progress.reconnections},
          {"bytes_sent", progress.bytes_sent},
          {"elapsed_s", outcome.elapsed_s},
          {"frames_per_s", outcome.frames_per_s()},
          {"revision", progress.revision}};
}

// Returns OK only if every frame of the source is in the map.
absl::Status StatusOf(const UploadOutcome& outcome) {
  const UploadProgress& progress = outcome.summary.progress;
  if (progress.refused > 0) {
    std::string message =
        CountText(progress.refused) + " of " + CountText(progress.pushed) + " frames were refused";
    if (outcome.summary.refused.empty()) return absl::InvalidArgumentError(message);
    const RefusedUpload& first = outcome.summary.refused.front();
    return MakeError(first.status.code(),
                     ReasonOf(first.status),
                     message + "; the first was frame " + std::to_string(first.client_seq) + ": " +
                         std::string(first.status.message()),
                     FieldOf(first.status));
  }
  if (outcome.unreadable.empty()) return absl::OkStatus();
  const absl::Status& first = outcome.unreadable.front().status;
  return absl::Status(first.code(),
                      CountText(outcome.unreadable.size()) +
                          " frames could not be read; the first: " + std::string(first.message()));
}

}  // namespace

void AddUploadRunOptions(CLI::App* command, UploadRunOptions* options) {
  command->add_option("--robot", options->source.robot, "Id of the robot that sends the frames")
      ->type_name("ID")
      ->capture_default_str();
  command->add_option("--sensor", options->source.sensor, "Id of the sensor on the robot")
      ->type_name("ID")
      ->capture_default_str();
  command
      ->add_option("--session",
                   options->session,
                   "Id of the upload session; the same command with the same id continues an "
                   "interrupted upload")
      ->type_name("ID");
  command
      ->add_option("--retry-for",
                   options->retry_for_s,
                   "Time for which to retry while the server cannot be reached, seconds")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->add_flag("--json", options->as_json, "Print the summary as JSON");
  AddMapOptions(command, &options->new_map);
}

absl::Status RunUpload(const UploadRunOptions& options,
                       FrameSource* source,
                       CommandContext* context) {
  const absl::StatusOr<MapName> name = ParseMapArgument(options.map);
  if (!name.ok()) return name.status();
  absl::Status status = CheckId("robot", options.source.robot);
  if (status.ok()) status = CheckId("sensor", options.source.sensor);
  if (status.ok() && !options.session.empty()) status = CheckId("session", options.session);
  if (!status.ok()) return status;
  const absl::StatusOr<UpdatePolicy> policy = EnsureMap(*name, options, context);
  if (!policy.ok()) return policy.status();

  const double start_s = SteadySeconds();
  ProgressReport report(
      &context->err, context->err_is_terminal, "integrated", source->frame_count(), SteadySeconds);
  UploadOutcome outcome;
  FrameReplay frames(source);
  FrameUploader uploader(context->Channels(), *name, OptionsOfUploader(options, &frames, &report));
  UploadWarnings notes(*policy);
  UploadAllCallbacks callbacks;
  callbacks.on_unreadable = [&outcome](const UnreadableFrame& frame) {
    outcome.unreadable.push_back(frame);
  };
  callbacks.on_frame = [&notes, &report](const v1::Frame& frame) {
    if (const std::optional<std::string> note = notes.Look(frame)) report.Note(*note);
  };
  absl::StatusOr<UploadSummary> summary = UploadAll(&frames, &uploader, callbacks);
  report.End();
  if (!summary.ok()) return summary.status();
  outcome.map = name->ToString();
  outcome.session = uploader.session();
  outcome.summary = *std::move(summary);
  outcome.elapsed_s = SteadySeconds() - start_s;
  if (options.as_json) {
    context->out << IndentedJson(SummaryJson(outcome));
  } else {
    WriteSummaryText(outcome, &context->out);
  }
  return StatusOf(outcome);
}

}  // namespace steadymap
