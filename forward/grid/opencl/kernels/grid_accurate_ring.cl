// Before grid_stream_prelude.cl: rings hold ACCU vectors.
#define RING_VEC accu_vec
