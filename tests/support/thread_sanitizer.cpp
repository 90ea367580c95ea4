// Synchronisation that ThreadSanitizer cannot detect, since Debian's Abseil, gRPC and oneTBB are
// not built for it: the mutexes of Abseil and the operations of gRPC. The functions are redefined
// here, for our code and for the libraries', and call the libraries' own; the preset `tsan` links
// this file into every program. Synchronisation inside gRPC and oneTBB stays undetected: races
// there are not reported.

#include <cstdlib>
#include <string>

#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>
#include <dlfcn.h>
#include <grpc/grpc.h>
#include <sanitizer/tsan_interface.h>

extern "C" {

/// Programs reference this symbol so that the linker includes this file.
void steadymap_thread_sanitizer() {}

// NOLINTNEXTLINE(bugprone-reserved-identifier): the sanitizer asks for it by this name.
const char* __tsan_default_options() { return "ignore_noninstrumented_modules=1"; }

// `race` matches any function of the stack, `race_top` the innermost only: callbacks of gRPC are
// our code, and races in them must be reported.
// NOLINTNEXTLINE(bugprone-reserved-identifier)
const char* __tsan_default_suppressions() {
  return "race:tbb::detail\n"
         "race:oneapi/tbb/\n"
         "race_top:grpc::\n"
         "race:grpc::SerializationTraits\n"
         "race:grpc::internal::CallOpSendMessage\n"
         "race:grpc::internal::CallOpSet\n"
         "race:grpc::internal::CallbackWithSuccessTag::Clear\n"
         "race:grpc::internal::InterceptorBatchMethodsImpl\n"
         "race:grpc::internal::ServerCallbackCall::Unref\n"
         "race_top:std::_Function_base::_M_empty\n"
         "race_top:std::function<void (bool)>\n";
}

}  // extern "C"

namespace {

#define STEADYMAP_TEXT_OF(name) #name
#define STEADYMAP_TEXT(name) STEADYMAP_TEXT_OF(name)

/// Returns the library's own function.
template <typename Function>
Function* Own(const std::string& symbol) {
  void* const found = dlsym(RTLD_NEXT, symbol.c_str());
  if (found == nullptr) std::abort();
  return reinterpret_cast<Function*>(found);
}

/// `member` is the mangled name after the namespace.
template <typename Function>
Function* AbseilsOwn(const std::string& member) {
  const std::string version = STEADYMAP_TEXT(ABSL_OPTION_INLINE_NAMESPACE_NAME);
  return Own<Function>("_ZN4absl" + std::to_string(version.size()) + version + member);
}

/// A condition that threads other than the waiting one also evaluate while they hold the mutex.
struct GuardedCondition {
  absl::Mutex* mutex;
  const absl::Condition* condition;

  bool Holds() {
    __tsan_acquire(mutex);
    const bool holds = condition->Eval();
    __tsan_release(mutex);
    return holds;
  }
};

/// Waits with `wait`, which takes the condition: writes of the thread before the wait are visible
/// to the threads that evaluate the condition.
template <typename Wait>
auto WaitFor(absl::Mutex* mutex, const absl::Condition& condition, const Wait& wait) {
  GuardedCondition guarded{mutex, &condition};
  const absl::Condition guarded_condition(&guarded, &GuardedCondition::Holds);
  __tsan_release(mutex);

  struct Acquire {
    absl::Mutex* mutex;

    ~Acquire() { __tsan_acquire(mutex); }
  } const at_return{mutex};

  return wait(guarded_condition);
}

}  // namespace

namespace absl {
ABSL_NAMESPACE_BEGIN

void Mutex::Lock() {
  static auto* const own = AbseilsOwn<void(Mutex*)>("5Mutex4LockEv");
  own(this);
  __tsan_acquire(this);
}

void Mutex::Unlock() {
  static auto* const own = AbseilsOwn<void(Mutex*)>("5Mutex6UnlockEv");
  __tsan_release(this);
  own(this);
}

bool Mutex::TryLock() {
  static auto* const own = AbseilsOwn<bool(Mutex*)>("5Mutex7TryLockEv");
  const bool locked = own(this);
  if (locked) __tsan_acquire(this);
  return locked;
}

void Mutex::ReaderLock() {
  static auto* const own = AbseilsOwn<void(Mutex*)>("5Mutex10ReaderLockEv");
  own(this);
  __tsan_acquire(this);
}

void Mutex::ReaderUnlock() {
  static auto* const own = AbseilsOwn<void(Mutex*)>("5Mutex12ReaderUnlockEv");
  __tsan_release(this);
  own(this);
}

bool Mutex::ReaderTryLock() {
  static auto* const own = AbseilsOwn<bool(Mutex*)>("5Mutex13ReaderTryLockEv");
  const bool locked = own(this);
  if (locked) __tsan_acquire(this);
  return locked;
}

void Mutex::LockWhen(const Condition& condition) {
  static auto* const own =
      AbseilsOwn<void(Mutex*, const Condition&)>("5Mutex8LockWhenERKNS0_9ConditionE");
  WaitFor(this, condition, [this](const Condition& guarded) { own(this, guarded); });
}

bool Mutex::LockWhenWithTimeout(const Condition& condition, Duration timeout) {
  static auto* const own = AbseilsOwn<bool(Mutex*, const Condition&, Duration)>(
      "5Mutex19LockWhenWithTimeoutERKNS0_9ConditionENS0_8DurationE");
  return WaitFor(
      this, condition, [&](const Condition& guarded) { return own(this, guarded, timeout); });
}

bool Mutex::LockWhenWithDeadline(const Condition& condition, Time deadline) {
  static auto* const own = AbseilsOwn<bool(Mutex*, const Condition&, Time)>(
      "5Mutex20LockWhenWithDeadlineERKNS0_9ConditionENS0_4TimeE");
  return WaitFor(
      this, condition, [&](const Condition& guarded) { return own(this, guarded, deadline); });
}

void Mutex::Await(const Condition& condition) {
  static auto* const own =
      AbseilsOwn<void(Mutex*, const Condition&)>("5Mutex5AwaitERKNS0_9ConditionE");
  WaitFor(this, condition, [this](const Condition& guarded) { own(this, guarded); });
}

bool Mutex::AwaitWithTimeout(const Condition& condition, Duration timeout) {
  static auto* const own = AbseilsOwn<bool(Mutex*, const Condition&, Duration)>(
      "5Mutex16AwaitWithTimeoutERKNS0_9ConditionENS0_8DurationE");
  return WaitFor(
      this, condition, [&](const Condition& guarded) { return own(this, guarded, timeout); });
}

bool Mutex::AwaitWithDeadline(const Condition& condition, Time deadline) {
  static auto* const own = AbseilsOwn<bool(Mutex*, const Condition&, Time)>(
      "5Mutex17AwaitWithDeadlineERKNS0_9ConditionENS0_4TimeE");
  return WaitFor(
      this, condition, [&](const Condition& guarded) { return own(this, guarded, deadline); });
}

void CondVar::Wait(Mutex* mutex) {
  static auto* const own = AbseilsOwn<void(CondVar*, Mutex*)>("7CondVar4WaitEPNS0_5MutexE");
  __tsan_release(mutex);
  own(this, mutex);
  __tsan_acquire(mutex);
}

bool CondVar::WaitWithTimeout(Mutex* mutex, Duration timeout) {
  static auto* const own = AbseilsOwn<bool(CondVar*, Mutex*, Duration)>(
      "7CondVar15WaitWithTimeoutEPNS0_5MutexENS0_8DurationE");
  __tsan_release(mutex);
  const bool timed_out = own(this, mutex, timeout);
  __tsan_acquire(mutex);
  return timed_out;
}

bool CondVar::WaitWithDeadline(Mutex* mutex, Time deadline) {
  static auto* const own =
      AbseilsOwn<bool(CondVar*, Mutex*, Time)>("7CondVar16WaitWithDeadlineEPNS0_5MutexENS0_4TimeE");
  __tsan_release(mutex);
  const bool timed_out = own(this, mutex, deadline);
  __tsan_acquire(mutex);
  return timed_out;
}

ABSL_NAMESPACE_END
}  // namespace absl

// Writes before the start of an operation of a call are visible to the thread that is notified of
// the end of an operation: gRPC releases the call for that operation before it notifies.

grpc_call_error grpc_call_start_batch(
    grpc_call* call, const grpc_op* operations, size_t count, void* tag, void* reserved) {
  static auto* const own = Own<decltype(grpc_call_start_batch)>("grpc_call_start_batch");
  __tsan_release(call);
  return own(call, operations, count, tag, reserved);
}

void grpc_call_unref(grpc_call* call) {
  static auto* const own = Own<decltype(grpc_call_unref)>("grpc_call_unref");
  __tsan_acquire(call);
  own(call);
}
