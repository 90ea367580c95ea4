#include "server/process/frame_budget.h"

#include <set>
#include <utility>

namespace steadymap {

FrameBudget::Reservation::Reservation(std::shared_ptr<Account> account, std::size_t bytes)
    : account_(std::move(account)), bytes_(bytes) {}

FrameBudget::Reservation::Reservation(Reservation&& other) noexcept
    : account_(std::move(other.account_)), bytes_(std::exchange(other.bytes_, 0)) {}

FrameBudget::Reservation& FrameBudget::Reservation::operator=(Reservation&& other) noexcept {
  if (this != &other) {
    Release();
    account_ = std::move(other.account_);
    bytes_ = std::exchange(other.bytes_, 0);
  }
  return *this;
}

FrameBudget::Reservation::~Reservation() { Release(); }

void FrameBudget::Reservation::Release() {
  const std::shared_ptr<Account> account = std::exchange(account_, nullptr);
  if (account == nullptr) return;
  State& state = *account->state_;
  std::list<Waiter> granted;
  {
    const absl::MutexLock lock(&state.mutex);
    account->used_bytes_ -= bytes_;
    state.used_bytes -= bytes_;
    granted = state.TakeForWaiters();
  }
  GrantAll(std::move(granted));
}

FrameBudget::FrameBudget(std::size_t total_bytes) : state_(std::make_shared<State>()) {
  SetTotal(total_bytes);
}

std::shared_ptr<FrameBudget::Account> FrameBudget::OpenAccount(std::size_t max_bytes) {
  auto account = std::make_shared<Account>();
  account->state_ = state_;
  SetMax(account, max_bytes);
  return account;
}

std::optional<FrameBudget::Reservation> FrameBudget::TryReserve(
    const std::shared_ptr<Account>& account, std::size_t bytes) {
  State& state = *account->state_;
  const absl::MutexLock lock(&state.mutex);
  if (state.Waits(*account) || !state.Fits(*account, bytes)) return std::nullopt;
  state.Take(*account, bytes);
  return Reservation(account, bytes);
}

void FrameBudget::Reserve(const std::shared_ptr<Account>& account, std::size_t bytes, Grant grant) {
  State& state = *account->state_;
  std::list<Waiter> granted;
  {
    const absl::MutexLock lock(&state.mutex);
    state.waiters.push_back({account, bytes, std::move(grant)});
    granted = state.TakeForWaiters();
  }
  GrantAll(std::move(granted));
}

void FrameBudget::Close(const std::shared_ptr<Account>& account) {
  State& state = *account->state_;
  // Destroyed after the lock is released: the destructor of a grant may call the budget.
  std::list<Waiter> dropped;
  {
    const absl::MutexLock lock(&state.mutex);
    for (auto waiter = state.waiters.begin(); waiter != state.waiters.end();) {
      const auto next = std::next(waiter);
      if (waiter->account == account) dropped.splice(dropped.end(), state.waiters, waiter);
      waiter = next;
    }
  }
}

void FrameBudget::SetTotal(std::size_t total_bytes) {
  std::list<Waiter> granted;
  {
    const absl::MutexLock lock(&state_->mutex);
    state_->max_bytes = total_bytes;
    granted = state_->TakeForWaiters();
  }
  GrantAll(std::move(granted));
}

void FrameBudget::SetMax(const std::shared_ptr<Account>& account, std::size_t max_bytes) {
  State& state = *account->state_;
  std::list<Waiter> granted;
  {
    const absl::MutexLock lock(&state.mutex);
    account->max_bytes_ = max_bytes;
    granted = state.TakeForWaiters();
  }
  GrantAll(std::move(granted));
}

std::size_t FrameBudget::used_bytes() const {
  const absl::MutexLock lock(&state_->mutex);
  return state_->used_bytes;
}

void FrameBudget::GrantAll(std::list<Waiter> granted) {
  for (Waiter& waiter : granted) {
    waiter.grant(Reservation(std::move(waiter.account), waiter.bytes));
  }
}

bool FrameBudget::State::Fits(const Account& account, std::size_t bytes) const {
  const auto fits = [bytes](std::size_t used, std::size_t max) {
    return used == 0 || (bytes <= max && used <= max - bytes);
  };
  return fits(account.used_bytes_, account.max_bytes_) && fits(used_bytes, max_bytes);
}

bool FrameBudget::State::Waits(const Account& account) const {
  for (const Waiter& waiter : waiters) {
    if (waiter.account.get() == &account) return true;
  }
  return false;
}

void FrameBudget::State::Take(Account& account, std::size_t bytes) {
  account.used_bytes_ += bytes;
  used_bytes += bytes;
}

std::list<FrameBudget::Waiter> FrameBudget::State::TakeForWaiters() {
  std::list<Waiter> granted;
  // A full map delays only its own requests, in order of arrival. Requests of other maps overtake
  // them.
  std::set<const Account*> held_up;
  for (auto waiter = waiters.begin(); waiter != waiters.end();) {
    const auto next = std::next(waiter);
    Account& account = *waiter->account;
    if (!held_up.contains(&account)) {
      if (Fits(account, waiter->bytes)) {
        Take(account, waiter->bytes);
        granted.splice(granted.end(), waiters, waiter);
      } else {
        held_up.insert(&account);
      }
    }
    waiter = next;
  }
  return granted;
}

}  // namespace steadymap
