#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "server/process/logging.h"
#include "server/store/model/store.h"

/// The configuration of steadymapd: plain structs with their defaults in place, the only place
/// where a default stands. `server/config/config_fields.h` lists every field once more, for
/// loading, validation, printing and documentation.
namespace steadymap {

/// What clients may ask for. SIGHUP reloads all of it.
struct LimitOptions {
  /// Largest message that is taken. A 4096 x 4096 frame of noise does not fit; no camera makes one.
  std::size_t max_message_bytes = std::size_t{8} << 20;

  /// Connections at once. Where the process may open fewer files (`ulimit -n`), that bounds them
  /// too: a quarter of those, up to 4096, is kept for the store. What is beyond is closed at once.
  std::size_t max_connections = 10'000;

  /// Upload streams at once, all maps together. 0: one for each 512 KiB of `queue_bytes_total`, and
  /// at least 16. More would wait for each other: half of so many frames of 640 x 480 fit in.
  std::size_t max_upload_streams = 0;

  /// Frames that one upload stream may have under way. Must cover a commit interval or the robot
  /// waits for it: 200 ms at 60 frames/s is 12.
  std::size_t upload_window_frames = 64;

  /// Bytes that one upload stream may have under way; at least `max_message_bytes`.
  std::size_t upload_window_bytes = std::size_t{32} << 20;

  /// Bytes of frames that wait for one map's integration. A busy map fills it and slows its robots.
  std::size_t queue_bytes_per_map = std::size_t{64} << 20;

  /// The same for all maps together. Messages that were read and wait to be decoded may take half
  /// as much again, of one map and of all: the bound on the daemon's memory under overload.
  std::size_t queue_bytes_total = std::size_t{128} << 20;

  /// Bytes of memory that the whole process may hold: beyond, neither frames nor new maps are taken
  /// until it holds less; reads go on. Zero: three quarters of what the machine, or the control
  /// group of the process, has.
  std::size_t memory_bytes = 0;
};

/// When the work of a mapping thread becomes visible and durable. Never changes what the map is.
struct CommitOptions {
  /// A revision is committed after this many frames. More amortises the sync, fewer shows sooner.
  std::size_t max_frames = 32;

  /// A revision is committed this long after its first frame at the latest.
  std::chrono::milliseconds max_delay{200};
};

/// What is kept longer than the present needs it.
struct RetentionOptions {
  /// Integrated frames leave the log after this time, for maps that do not say otherwise. Zero: at
  /// once. A map can be rebuilt under another policy while its log lasts.
  std::chrono::seconds frame_log_age{24 * 3600};

  /// The oldest integrated frames leave the log when it holds more bytes, for maps that do not say
  /// otherwise.
  std::uint64_t frame_log_bytes = std::uint64_t{4} << 30;

  /// Upload sessions are forgotten when idle for this long; a frame sent again later would count
  /// twice. The service contract promises 7 days.
  std::chrono::seconds session_idle{14 * 24 * 3600};

  /// How often retention is applied.
  std::chrono::seconds trim_interval{60};
};

/// Those who watch maps.
struct WatchServiceOptions {
  /// Watches at once, all maps together. Each costs some kilobytes, and while it takes a step the
  /// message at hand.
  std::size_t max_watches = 2000;

  /// Watches that one address may open a second, behind a burst of twice `max_watches`: what a
  /// fleet behind one address needs after a restart, and a bound on clients that come back in a
  /// loop.
  std::size_t openings_per_second = 20;

  /// A client that takes nothing of what a watch, an export or a section sends it for this long is
  /// ended with SLOW_CONSUMER, which it learns when it reads again; later it is cut off. A watch
  /// may resume.
  std::chrono::seconds stall_timeout{60};
};

/// Everything that an operator can set.
struct ServerConfig {
  /// Host and port of the gRPC listener; port 0 takes a free one.
  std::string listen = "localhost:7443";

  /// Folder of the store; made if it does not exist.
  std::string data_dir = "/var/lib/steadymap";

  /// Plain text on an address that other machines can reach must be asked for.
  bool allow_plaintext_remote = false;

  /// gRPC server reflection, for grpcurl and the like.
  bool reflection = true;

  /// gRPC channelz, for debugging connections. Shows peers' addresses to every client.
  bool channelz = false;

  /// Longest time from SIGTERM to the end. systemd's TimeoutStopSec must exceed it.
  std::chrono::seconds drain_timeout{30};

  LoggingOptions log;
  LimitOptions limits;
  CommitOptions commit;
  RetentionOptions retention;
  WatchServiceOptions watch;
  StoreOptions store;
};

/// Every violation of a range or of a rule between fields, one sentence each that starts with the
/// field's name; empty if the configuration can be used. Repairs nothing.
std::vector<std::string> FindViolations(const ServerConfig& config);

/// OK, or `InvalidArgument` with all of `FindViolations` in one message.
absl::Status ValidateServerConfig(const ServerConfig& config);

/// Takes from `fresh` what may change while the server runs: `log.level`, `drain_timeout`, and
/// `limits` but for `max_message_bytes`.
void ApplyReloadable(const ServerConfig& fresh, ServerConfig* running);

/// The fields in which two configurations differ, each as `NAME: BEFORE -> AFTER`, in their order.
std::vector<std::string> FindDifferences(const ServerConfig& before, const ServerConfig& after);

/// Whether `listen` names this machine's loopback interface: `localhost`, 127.0.0.0/8, `[::1]`, or
/// a unix socket.
bool IsLoopback(const std::string& listen);

/// `listen` with `port` in place of the port it names; a unix socket is left as it is.
std::string WithPort(const std::string& listen, int port);

}  // namespace steadymap
