#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <optional>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

namespace steadymap {

/// A memory budget for in-flight frames, from before decoding until integration: a number of bytes
/// per map, and a number of bytes for all maps together. A request beyond the budget waits. The
/// requests of one map are granted in order of arrival, so robots share a busy map fairly.
///
/// A frame larger than a limit is admitted when no other bytes are reserved under that limit, so
/// that it does not wait forever.
/// Thread-safe. Accounts and reservations may outlive the budget.
class FrameBudget {
  struct State;

 public:
  /// The share of one map.
  class Account;

  /// Reserved bytes; the destructor releases them.
  class Reservation {
   public:
    Reservation() = default;
    Reservation(Reservation&& other) noexcept;
    Reservation& operator=(Reservation&& other) noexcept;
    ~Reservation();

    std::size_t bytes() const { return bytes_; }

   private:
    friend class FrameBudget;
    Reservation(std::shared_ptr<Account> account, std::size_t bytes);
    void Release();

    std::shared_ptr<Account> account_;
    std::size_t bytes_ = 0;
  };

  /// Receives a reservation after a wait. May be called from any thread that releases bytes, so it
  /// must hand longer work to another thread.
  using Grant = std::function<void(Reservation)>;

  explicit FrameBudget(std::size_t total_bytes);

  /// Opens the account of a map, with a share of at most `max_bytes`.
  std::shared_ptr<Account> OpenAccount(std::size_t max_bytes);

  /// Reserves `bytes` if they are free and no other request of the map is waiting.
  static std::optional<Reservation> TryReserve(const std::shared_ptr<Account>& account,
                                               std::size_t bytes);

  /// Reserves `bytes` as soon as they are free and then calls `grant` once, possibly before this
  /// call returns. A grant that is still waiting when its account is closed is dropped.
  static void Reserve(const std::shared_ptr<Account>& account, std::size_t bytes, Grant grant);

  /// Drops all waiting requests of the account.
  static void Close(const std::shared_ptr<Account>& account);

  /// Sets a new limit. Existing reservations are kept.
  void SetTotal(std::size_t total_bytes);
  static void SetMax(const std::shared_ptr<Account>& account, std::size_t max_bytes);

  /// Returns the number of reserved bytes.
  std::size_t used_bytes() const;

 private:
  struct Waiter {
    std::shared_ptr<Account> account;
    std::size_t bytes = 0;
    Grant grant;
  };

  /// State shared by all accounts. Outlives the budget while an account exists.
  struct State {
    bool Fits(const Account& account, std::size_t bytes) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex);
    bool Waits(const Account& account) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex);
    void Take(Account& account, std::size_t bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex);

    /// Reserves bytes for all waiters that fit now. The caller must call their grants.
    std::list<Waiter> TakeForWaiters() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex);

    mutable absl::Mutex mutex;
    std::size_t max_bytes ABSL_GUARDED_BY(mutex) = 0;
    std::size_t used_bytes ABSL_GUARDED_BY(mutex) = 0;
    std::list<Waiter> waiters ABSL_GUARDED_BY(mutex);
  };

  static void GrantAll(std::list<Waiter> granted);

  std::shared_ptr<State> state_;
};

/// Opaque to all code except the budget.
class FrameBudget::Account {
 private:
  friend class FrameBudget;
  friend struct FrameBudget::State;

  std::shared_ptr<State> state_;
  std::size_t max_bytes_ = 0;   ///< Guarded by the mutex of the state.
  std::size_t used_bytes_ = 0;  ///< Guarded by the mutex of the state.
};

}  // namespace steadymap
