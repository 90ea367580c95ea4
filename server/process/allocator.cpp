// The daemon's allocator is jemalloc, which gives memory back that glibc keeps: after a large
// export or the end of a map the process must not stay as large as it once was. These are its
// options; it reads them before `main`.

// Pages that have been free for a second go back to the system, on a thread of the allocator's own.
// NOLINTNEXTLINE(readability-identifier-naming): jemalloc's name.
extern "C" const char* malloc_conf;
const char* malloc_conf = "background_thread:true,dirty_decay_ms:1000,muzzy_decay_ms:0";
