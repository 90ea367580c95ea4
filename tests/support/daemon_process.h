#pragma once

#include <chrono>
#include <filesystem>
#include <string>

#include <sys/types.h>

namespace steadymap {

/// Result of a process.
struct ProcessEnd {
  int exit_code = 0;   ///< 128 plus the signal if a signal ended it.
  std::string errors;  ///< Content of standard error.
};

/// The `steadymapd` of this build as a child process on loopback, with its store, log and port file
/// in its own folder. Throws `std::runtime_error` with the daemon's log if it does not start.
class DaemonProcess {
 public:
  /// Starts it on a free port and waits until it listens.
  explicit DaemonProcess(std::filesystem::path folder);

  /// Kills it if it still runs.
  ~DaemonProcess();

  DaemonProcess(const DaemonProcess&) = delete;
  DaemonProcess& operator=(const DaemonProcess&) = delete;

  /// `127.0.0.1:PORT`, independent of the machine's name resolution; unchanged by restarts.
  const std::string& address() const { return address_; }

  /// Id of the running process.
  pid_t process() const { return process_; }

  /// Sends SIGKILL; returns when the process has ended.
  void Kill();

  /// Sends SIGTERM; returns the result.
  ProcessEnd Terminate();

  /// Starts it again, with the same store and port.
  void Restart();

  /// Returns the time from the last start until the health service answered SERVING; waits at most
  /// 30 s.
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
