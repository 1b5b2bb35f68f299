// Values of faces in double, [pattern][sample] with `stride` values a pattern, and the solver's by
// [sample][lane] in STORED. One item per sample.

#define SAMPLE                         \
  const size_t k = get_global_id(0); \
  if (k >= (size_t)samples) return;

// The `count` patterns from `first` on, times `factor`; the lanes beyond are zero.
kernel void pack_samples(const int samples, const int lanes, const int count, const int first,
                         const int stride, const double factor,
                         global const double* restrict values, global STORED* restrict packed) {
  SAMPLE
  for (int m = 0; m < lanes; ++m) {
    packed[k * lanes + m] =
        m < count ? (STORED)(factor * values[first + (size_t)m * stride + k]) : (STORED)0;
  }
}

kernel void unpack_samples(const int samples, const int lanes, const int count, const int first,
                           const int stride, global const STORED* restrict packed,
                           global double* restrict values) {
  SAMPLE
  for (int m = 0; m < count; ++m) values[first + (size_t)m * stride + k] = packed[k * lanes + m];
}

// Σ over patterns of weights times the exitance that a conductance multiplies, all of it but
// `apart` of the light; of the face whose samples begin at `first` among the `stride` of a pattern.
kernel void observe(const int samples, const int first, const int stride, const int patterns,
                    const double apart, global const double* restrict weights,
                    global const double* restrict exitance, global const double* restrict light,
                    global double* restrict sums) {
  SAMPLE
  double sum = 0;
  for (int m = 0; m < patterns; ++m) {
    const size_t i = (size_t)m * stride + first + k;
    const double entered = apart == 0 ? 0 : apart * light[(size_t)m * samples + k];
    sum += weights[i] * (exitance[i] - entered);
  }
  sums[first + k] = sum;
}
