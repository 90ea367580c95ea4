#pragma once

#include <chrono>
#include <filesystem>
#include <string>

#include <sys/types.h>

namespace steadymap {

/// How a process ended.
struct ProcessEnd {
  int exit_code = 0;   ///< 128 plus the signal if one ended it.
  std::string errors;  ///< What it wrote to standard error.
};

/// The `steadymapd` of this build as a child process on loopback, with its store, log and port file
/// in a folder of its own. Throws `std::runtime_error` with the daemon's log if it does not come
/// up.
class DaemonProcess {
 public:
  /// Starts it on a free port and waits until it listens.
  explicit DaemonProcess(std::filesystem::path folder);

  /// Kills it if it still runs.
  ~DaemonProcess();

  DaemonProcess(const DaemonProcess&) = delete;
  DaemonProcess& operator=(const DaemonProcess&) = delete;

  /// `127.0.0.1:PORT`, whatever names the machine knows; stays the same over restarts.
  const std::string& address() const { return address_; }

  /// Id of the running process.
  pid_t process() const { return process_; }

  /// kill -9; returns when the process is gone.
  void Kill();

  /// SIGTERM; returns how it ended.
  ProcessEnd Terminate();

  /// Starts it again, over the same store and on the same port.
  void Restart();

  /// Time from the last start until the health service answered SERVING. Asks until it does, at
  /// most for 30 s.
  std::chrono::duration<double> AwaitServing() const;

 private:
  void Start(const std::string& listen);
  void AwaitPortFile(int life_line) const;
  std::string Log() const;

  std::filesystem::path folder_;
  std::string address_;
  pid_t process_ = -1;
  std::chrono::steady_clock::time_point started_;
};

}  // namespace steadymap
