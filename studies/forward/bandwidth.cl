// Copies of 16 floats per step, or 4 on GPUs, whose widest access that is. Items stride through the
// buffer where neighbouring items should touch neighbouring memory (GPUs), or take one stretch
// each.
#ifndef INTERLEAVED
#define INTERLEAVED 0
#endif
#ifdef __has_builtin
#if __has_builtin(__builtin_nontemporal_store)
#define STREAM_OUT(value, address) __builtin_nontemporal_store(value, address)
#endif
#endif
#ifndef STREAM_OUT
#define STREAM_OUT(value, address) (*(address) = (value))
#endif

#if INTERLEAVED
typedef float4 piece;
#define FOR_OWN for (int i = (int)get_global_id(0); i < count; i += (int)get_global_size(0))
#else
typedef float16 piece;
#define FOR_OWN                                                 \
  const int length = (count - 1) / (int)get_global_size(0) + 1; \
  const int begin = (int)get_global_id(0) * length;             \
  for (int i = begin; i < min(begin + length, count); ++i)
#endif

kernel void copy(const int count, global const piece* restrict from, global piece* restrict to) {
  FOR_OWN {
    to[i] = from[i];
  }
}

kernel void copy_past_cache(const int count, global const piece* restrict from,
                            global piece* restrict to) {
  FOR_OWN {
    STREAM_OUT(from[i], to + i);
  }
}
