#include "tests/support/proxy_connection.h"

#include <algorithm>
#include <cerrno>

#include <sys/socket.h>

namespace steadymap {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{64} << 10;

// Maximum rate of turns of a throttled lane, and maximum allowance, in turns.
constexpr double kTurnsPerSecond = 50.0;
constexpr double kSavedTurns = 2.0;

bool WouldWait() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

void ProxyLane::Refill(Clock::time_point now, std::size_t bytes_per_second) {
  if (bytes_per_second != rate_) {
    rate_ = bytes_per_second;
    quantum_ = rate_ == 0 ? 0.0
                          : std::clamp(static_cast<double>(rate_) / kTurnsPerSecond,
                                       1.0,
                                       static_cast<double>(kBufferBytes));
    allowance_ = 0.0;
    filled_ = now;
  }
  const double passed_s = std::chrono::duration<double>(now - filled_).count();
  allowance_ = std::min(allowance_ + passed_s * static_cast<double>(rate_), kSavedTurns * quantum_);
  filled_ = now;
}

std::optional<ProxyLane::Clock::time_point> ProxyLane::next_refill() const {
  if (begin_ < end_ || ended_ || allowance_ >= quantum_) return std::nullopt;
  const std::chrono::duration<double> wait((quantum_ - allowance_) / static_cast<double>(rate_));
  return filled_ + std::chrono::ceil<Clock::duration>(wait);
}

bool ProxyLane::Read() {
  buffer_.resize(kBufferBytes);
  const std::size_t most =
      rate_ == 0 ? kBufferBytes : std::min(kBufferBytes, static_cast<std::size_t>(allowance_));
  const ssize_t count = recv(source_, buffer_.data(), most, 0);
  if (count < 0) return WouldWait();
  begin_ = 0;
  end_ = static_cast<std::size_t>(count);
  if (rate_ != 0) allowance_ -= static_cast<double>(count);
  if (count > 0) return true;
  ended_ = true;
  return shutdown(destination_, SHUT_WR) == 0;
}

std::optional<std::size_t> ProxyLane::Move() {
  if (wants_source() && !Read()) return std::nullopt;
  if (begin_ == end_) return 0;
  const ssize_t count = send(destination_, buffer_.data() + begin_, end_ - begin_, MSG_NOSIGNAL);
  if (count < 0 && !WouldWait()) return std::nullopt;
  const auto moved = static_cast<std::size_t>(std::max<ssize_t>(count, 0));
  begin_ += moved;
  return moved;
}

ProxyConnection::ProxyConnection(Descriptor client, Descriptor target)
    : client_(std::move(client)),
      target_(std::move(target)),
      to_target_(client_.number(), target_.number()),
      to_client_(target_.number(), client_.number()) {}

void ProxyConnection::AppendPolled(std::vector<pollfd>* polled) const {
  const auto entry = [](const Descriptor& socket, bool reads, bool writes) {
    const int events = (reads ? POLLIN : 0) | (writes ? POLLOUT : 0);
    // poll(2) always reports hang-ups, which would wake a thread that cannot handle them.
    return pollfd{events == 0 ? -1 : socket.number(), static_cast<short>(events), 0};
  };
  if (!connected_) {
    polled->push_back(entry(client_, false, false));
    polled->push_back(entry(target_, false, true));
    return;
  }
  polled->push_back(entry(client_, to_target_.wants_source(), to_client_.wants_destination()));
  polled->push_back(entry(target_, to_client_.wants_source(), to_target_.wants_destination()));
}

void ProxyConnection::Refill(Clock::time_point now, std::size_t bytes_per_second) {
  to_target_.Refill(now, bytes_per_second);
  to_client_.Refill(now, bytes_per_second);
}

std::optional<ProxyConnection::Clock::time_point> ProxyConnection::next_refill() const {
  const auto target = to_target_.next_refill();
  const auto client = to_client_.next_refill();
  if (!target || !client) return target ? target : client;
  return std::min(*target, *client);
}

ProxyConnection::Turn ProxyConnection::Move(const pollfd& client, const pollfd& target) {
  Turn turn;
  if (client.revents == 0 && target.revents == 0) return turn;
  if (!connected_ && !FinishConnecting()) {
    Reset();
    turn.over = true;
    return turn;
  }
  const std::optional<std::size_t> to_target = to_target_.Move();
  const std::optional<std::size_t> to_client = to_client_.Move();
  turn.to_target_bytes = to_target.value_or(0);
  turn.to_client_bytes = to_client.value_or(0);
  if (!to_target || !to_client) {
    Reset();
    turn.over = true;
  }
  turn.over = turn.over || (to_target_.ended() && to_client_.ended());
  return turn;
}

void ProxyConnection::Reset() {
  ResetSocket(&client_);
  ResetSocket(&target_);
}

bool ProxyConnection::FinishConnecting() {
  int error = 0;
  socklen_t size = sizeof(error);
  if (getsockopt(target_.number(), SOL_SOCKET, SO_ERROR, &error, &size) != 0 || error != 0) {
    return false;
  }
  connected_ = true;
  return true;
}

void ResetSocket(Descriptor* socket) {
  const linger at_once{1, 0};
  setsockopt(socket->number(), SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
  socket->Close();
}

}  // namespace steadymap
