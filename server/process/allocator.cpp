// Options of jemalloc, the allocator of the daemon, which reads them before `main`. Unlike glibc,
// jemalloc returns freed memory to the system, so the process shrinks after a large export or the
// deletion of a map.

// A background thread of the allocator returns pages to the system after they have been free for 1
// s.
// NOLINTNEXTLINE(readability-identifier-naming): jemalloc's name.
extern "C" const char* malloc_conf;
const char* malloc_conf = "background_thread:true,dirty_decay_ms:1000,muzzy_decay_ms:0";
