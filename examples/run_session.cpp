// A capture session to volumes of κ and μ on disk: run_session SESSION RUN
#include <kappamu/pipeline/pipeline.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 3) return std::puts("usage: run_session SESSION RUN"), 2;
  try {
    kappamu::Progress quiet;  // derive from it to see progress; throw Cancelled from it to stop
    kappamu::pipeline::Pipeline run(argv[1], argv[2]);
    run.calibrate(quiet);
    run.merge(quiet);
    run.fit({}, quiet);
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
