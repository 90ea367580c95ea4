#include "client/cli/text/stop_signal.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <limits>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

namespace steadymap {
namespace {

constexpr int kNone = -1;

// State that the signal handler may access.
std::atomic<int> wake_descriptor{kNone};
std::atomic<bool> signal_came{false};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

struct sigaction interrupt_before;
struct sigaction terminate_before;

void Wake() {
  const std::uint64_t one = 1;
  // Fails only if the counter is full; then no thread is blocked.
  [[maybe_unused]] const ssize_t written = write(wake_descriptor, &one, sizeof(one));
}

void OnStopSignal(int) {
  const int error = errno;
  signal_came = true;
  Wake();
  errno = error;
}

}  // namespace

StopSignal::StopSignal() {
  assert(wake_descriptor == kNone);
  signal_came = false;
  wake_descriptor = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  assert(wake_descriptor >= 0);

  struct sigaction action {};

  action.sa_handler = OnStopSignal;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, &interrupt_before);
  sigaction(SIGTERM, &action, &terminate_before);
}

StopSignal::~StopSignal() {
  sigaction(SIGINT, &interrupt_before, nullptr);
  sigaction(SIGTERM, &terminate_before, nullptr);
  close(wake_descriptor.exchange(kNone));
}

void StopSignal::Notify() { Wake(); }

void StopSignal::Wait(std::optional<std::chrono::milliseconds> timeout) {
  using Milliseconds = std::chrono::milliseconds;
  const Milliseconds longest(std::numeric_limits<int>::max());
  const int timeout_ms =
      timeout ? static_cast<int>(std::clamp(*timeout, Milliseconds(0), longest).count()) : -1;
  pollfd waiting{wake_descriptor, POLLIN, 0};
  // If a signal interrupts the wait, its handler has already ended it.
  if (poll(&waiting, 1, timeout_ms) <= 0) return;
  std::uint64_t count = 0;
  [[maybe_unused]] const ssize_t taken = read(wake_descriptor, &count, sizeof(count));
}

bool StopSignal::came() const { return signal_came; }

}  // namespace steadymap
