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

/// A network between clients and one server that a test can make worse: it listens on a free port
/// of loopback and passes bytes on to a target. Between the two sockets of a connection it holds at
/// most 64 KiB each way, and the kernel some hundred more, so that a stall is soon felt.
///
/// One thread does the work. All functions are thread-safe, and what they order holds when they
/// return.
class TcpProxy {
 public:
  /// `target` is `HOST:PORT` with a numeric IPv4 host; nobody needs to listen there yet. Throws
  /// `std::invalid_argument` for anything else, `std::system_error` if there is no socket.
  explicit TcpProxy(const std::string& target);

  /// Cuts all connections.
  ~TcpProxy();

  TcpProxy(const TcpProxy&) = delete;
  TcpProxy& operator=(const TcpProxy&) = delete;

  /// Where clients connect: `127.0.0.1:PORT`, the same as long as the proxy lives.
  const std::string& address() const { return address_; }

  /// Connections that come from now on lead to `target`; those that are open stay.
  void SetTarget(const std::string& target);

  /// Resets all connections, both sides, whatever was on its way.
  void Cut();

  /// From now on nothing moves: nothing is read, written or noticed, and connections stay. New ones
  /// are accepted, and nothing of them moves either.
  void Stall();

  /// Ends a stall.
  void Resume();

  /// Each connection passes on at most this many bytes a second each way; 0: no limit.
  void Throttle(std::size_t bytes_per_second);

  /// Whether new connections are reset instead of served.
  void Refuse(bool refuses);

  /// What has gone through so far.
  struct Counters {
    std::uint64_t to_target_bytes = 0;   ///< That the target's socket took.
    std::uint64_t to_clients_bytes = 0;  ///< That clients' sockets took.
    std::uint64_t accepted = 0;          ///< Connections of clients, refused ones included.
    std::uint64_t open = 0;              ///< Connections there are.
  };

  /// Nothing that has arrived at either end is missing from it.
  Counters counters();

 private:
  /// What was ordered last.
  struct Orders {
    std::string target;
    std::size_t bytes_per_second = 0;
    bool stalled = false;
    bool refuses = false;
    bool stops = false;
    std::uint64_t cuts = 0;  ///< How often.
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

  // Of the thread alone.
  std::vector<std::unique_ptr<ProxyConnection>> connections_;
  std::uint64_t cuts_ = 0;  ///< Carried out.
  Counters counted_;

  absl::Mutex mutex_;
  Orders orders_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t ordered_ ABSL_GUARDED_BY(mutex_) = 0;
  std::uint64_t carried_out_ ABSL_GUARDED_BY(mutex_) = 0;  ///< Of those.
  Counters published_ ABSL_GUARDED_BY(mutex_);             ///< When they were carried out.

  std::thread thread_;  ///< Last: it uses everything above.
};

}  // namespace steadymap
