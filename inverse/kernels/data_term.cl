// Σ w (r M − d)² of exitance M, and the derivatives of half of it by M. Data without weight are not
// looked at: M may be anything there.
REDUCTION void gaussian_misfit(const int count, global const double* restrict exitance,
                               global const double* restrict ratio,
                               global const double* restrict data,
                               global const double* restrict weight,
                               global double* restrict by_exitance,
                               global double* restrict partial) {
  local double scratch[GROUP];
  double sum = 0;
  FOR_ELEMENTS(i, count) {
    double slope = 0;
    if (weight[i] > 0) {
      const double residual = ratio[i] * exitance[i] - data[i];
      slope = weight[i] * residual;
      sum += slope * residual;
    }
    by_exitance[i] = slope * ratio[i];
  }
  leave(sum, 0, 0, scratch, partial);
}
