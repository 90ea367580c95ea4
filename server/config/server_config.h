#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "server/process/logging.h"
#include "server/store/model/store.h"

/// The configuration of steadymapd: plain structs with their defaults, which are defined only here.
/// `server/config/config_fields.h` lists all fields for loading, validation, printing and
/// documentation.
namespace steadymap {

/// Limits on the use of the server by clients. SIGHUP reloads all of them except
/// `max_message_bytes`.
struct LimitOptions {
  /// Maximum size of an accepted message in bytes. The default excludes only a 4096 x 4096 frame of
  /// pure noise, which no camera produces.
  std::size_t max_message_bytes = std::size_t{8} << 20;

  /// Maximum number of simultaneous connections. The limit on open files (`ulimit -n`) also bounds
  /// them: a quarter of that limit, clamped to [64, 4096], is reserved for the store. Further
  /// connections are closed immediately.
  std::size_t max_connections = 10'000;

  /// Maximum number of simultaneous upload streams, all maps together. 0: one per 512 KiB of
  /// `queue_bytes_total`, and at least 16. The default queue holds a 640 x 480 frame for half of
  /// that many streams; with more streams, robots would wait for each other.
  std::size_t max_upload_streams = 0;

  /// Maximum number of in-flight frames of one upload stream. Must cover a commit interval, or the
  /// robot waits for acknowledgements: 200 ms at 60 frames/s is 12 frames.
  std::size_t upload_window_frames = 64;

  /// Maximum number of in-flight bytes of one upload stream; at least `max_message_bytes`.
  std::size_t upload_window_bytes = std::size_t{32} << 20;

  /// Maximum number of bytes of frames that wait for the integration into one map. A busy map
  /// reaches it and slows its robots down.
  std::size_t queue_bytes_per_map = std::size_t{64} << 20;

  /// Maximum number of bytes of frames that wait for integration, all maps together. Messages that
  /// wait for decoding may use half as much in addition, per map and in total. Together they bound
  /// the memory of the daemon under overload.
  std::size_t queue_bytes_total = std::size_t{128} << 20;

  /// Maximum number of bytes of memory of the whole process. Above it, frames and new maps are
  /// refused until the process uses less; reads are still served. 0: three quarters of the memory
  /// of the machine or of the limit of the process's control group.
  std::size_t memory_bytes = 0;
};

/// When integrated frames become visible and durable. Does not change the content of the map.
struct CommitOptions {
  /// A revision is committed after this many frames. A larger number spreads the cost of a disk
  /// sync over more frames; a smaller number makes changes visible sooner.
  std::size_t max_frames = 32;

  /// A revision is committed at the latest this long after its first frame.
  std::chrono::milliseconds max_delay{200};
};

/// When the session of a robot ends, after which a `pocd` map decides what the robot has seen.
struct SessionOptions {
  /// A session also ends this long after its last frame if the robot did not end its upload, for
  /// example because it was switched off.
  std::chrono::seconds max_silence{60};
};

/// Retention of data that the current map no longer needs.
struct RetentionOptions {
  /// Integrated frames are removed from the log after this time, unless the map has its own
  /// setting. 0: immediately. A map can be rebuilt under another policy while its frames are in the
  /// log.
  std::chrono::seconds frame_log_age{24 * 3600};

  /// The oldest integrated frames are removed from the log when it exceeds this number of bytes,
  /// unless the map has its own setting.
  std::uint64_t frame_log_bytes = std::uint64_t{4} << 30;

  /// Upload sessions are deleted when idle for this long. A frame that is sent again after that
  /// would be integrated twice. The service contract promises 7 days.
  std::chrono::seconds session_idle{14 * 24 * 3600};

  /// Interval at which the retention is applied.
  std::chrono::seconds trim_interval{60};
};

/// Limits on watches.
struct WatchServiceOptions {
  /// Maximum number of simultaneous watches, all maps together. Each uses some kilobytes, and
  /// during a step also the memory of its current message.
  std::size_t max_watches = 2000;

  /// Watches that one IP address may open per second, after a burst of twice `max_watches`. The
  /// burst covers a fleet behind one address that reconnects after a restart; the rate bounds
  /// clients that reconnect in a loop.
  std::size_t openings_per_second = 20;

  /// A watch, export or section stream whose client reads nothing for this long ends with
  /// SLOW_CONSUMER. The client receives the error when it reads again; after a further delay the
  /// call is cancelled. A watch can be resumed.
  std::chrono::seconds stall_timeout{60};
};

/// All settings of the daemon.
struct ServerConfig {
  /// Host and port of the gRPC listener; port 0 selects a free port.
  std::string listen = "localhost:7443";

  /// Folder of the store; created if it does not exist.
  std::string data_dir = "/var/lib/steadymap";

  /// Allows unencrypted connections on an address that other machines can reach.
  bool allow_plaintext_remote = false;

  /// Enables gRPC server reflection, for grpcurl and similar tools.
  bool reflection = true;

  /// Enables gRPC channelz, for debugging connections. Exposes the addresses of peers to every
  /// client.
  bool channelz = false;

  /// Maximum time from SIGTERM to the end of the process. Must be less than TimeoutStopSec of
  /// systemd.
  std::chrono::seconds drain_timeout{30};

  LoggingOptions log;
  LimitOptions limits;
  CommitOptions commit;
  SessionOptions sessions;
  RetentionOptions retention;
  WatchServiceOptions watch;
  StoreOptions store;
};

/// Returns a sentence for each violation of a range or of a rule between fields, beginning with the
/// name of the field. Empty if the configuration is valid. Changes no value.
std::vector<std::string> FindViolations(const ServerConfig& config);

/// Returns OK, or `InvalidArgument` with all sentences of `FindViolations` in one message.
absl::Status ValidateServerConfig(const ServerConfig& config);

/// Copies the reloadable settings from `fresh` to `running`: `log.level`, `drain_timeout`, and all
/// of `limits` except `max_message_bytes`.
void ApplyReloadable(const ServerConfig& fresh, ServerConfig* running);

/// Returns the fields in which two configurations differ, each as `NAME: BEFORE -> AFTER`, in the
/// order of the file.
std::vector<std::string> FindDifferences(const ServerConfig& before, const ServerConfig& after);

/// True if `listen` is on the loopback interface of this machine: `localhost`, 127.0.0.0/8,
/// `[::1]`, or a unix socket.
bool IsLoopback(const std::string& listen);

/// Returns `listen` with its port replaced by `port`; a unix socket is returned unchanged.
std::string WithPort(const std::string& listen, int port);

}  // namespace steadymap
