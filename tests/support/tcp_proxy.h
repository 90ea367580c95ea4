#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include "tests/support/descriptor.h"
#include "tests/support/proxy_connection.h"

namespace steadymap {

/// A TCP proxy between clients and one server with fault injection: it listens on a free port of
/// loopback and forwards bytes to a target. Per connection it buffers at most 64 KiB each way, and
/// the kernel a few hundred KiB more, so that a stall takes effect quickly.
///
/// Runs one thread. All functions are thread-safe, and their effect is complete when they return.
class TcpProxy {
 public:
  /// `target` is `HOST:PORT` with a numeric IPv4 host; a listener is not required yet. Throws
  /// `std::invalid_argument` for any other form, `std::system_error` if a socket cannot be created.
  explicit TcpProxy(const std::string& target);

  /// Resets all connections.
  ~TcpProxy();

  TcpProxy(const TcpProxy&) = delete;
  TcpProxy& operator=(const TcpProxy&) = delete;

  /// Address for clients: `127.0.0.1:PORT`, constant for the lifetime of the proxy.
  const std::string& address() const { return address_; }

  /// Connects later connections to `target`; open ones are unchanged.
  void SetTarget(const std::string& target);

  /// Resets both sides of all connections; bytes in transit are lost.
  void Cut();

  /// Stops all traffic: no byte is read or written and no event is processed, but connections stay
  /// open. New connections are accepted and also stalled.
  void Stall();

  /// Ends a stall.
  void Resume();

  /// Limits the bytes per second of each connection and direction; 0: no limit.
  void Throttle(std::size_t bytes_per_second);

  /// True: new connections are reset instead of forwarded.
  void Refuse(bool refuses);

  /// Counters of the traffic so far.
  struct Counters {
    std::uint64_t to_target_bytes = 0;   ///< Accepted by the target's sockets.
    std::uint64_t to_clients_bytes = 0;  ///< Accepted by the clients' sockets.
    std::uint64_t accepted = 0;          ///< Client connections, including refused ones.
    std::uint64_t open = 0;              ///< Open connections.
  };

  /// Includes all bytes that have arrived at either end.
  Counters counters();

 private:
  /// The current orders.
  struct Orders {
    std::string target;
    std::size_t bytes_per_second = 0;
    bool stalled = false;
    bool refuses = false;
    bool stops = false;
    std::uint64_t cuts = 0;  ///< Number of cuts.
  };

  Counters Order(const std::function<void(Orders*)>& change) ABSL_LOCKS_EXCLUDED(mutex_);
  void Run();
  Orders CarryOutOrders() ABSL_LOCKS_EXCLUDED(mutex_);
  std::vector<pollfd> Poll(const Orders& orders);
  void MoveBytes(const std::vector<pollfd>& polled);
  void AcceptClients(const Orders& orders);

  Descriptor wake_;
  Descriptor listener_;
  std::string address_;

  // Used by the thread only.
  std::vector<std::unique_ptr<ProxyConnection>> connections_;
  std::uint64_t cuts_ = 0;  ///< Number of cuts carried out.
  Counters counted_;

  absl::Mutex mutex_;
  Orders orders_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t ordered_ ABSL_GUARDED_BY(mutex_) = 0;
  std::uint64_t carried_out_ ABSL_GUARDED_BY(mutex_) = 0;  ///< Of `ordered_`.
  Counters published_ ABSL_GUARDED_BY(mutex_);             ///< At that time.

  std::thread thread_;  ///< Last member: it uses all members above.
};

}  // namespace steadymap
