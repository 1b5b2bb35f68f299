// Every rank runs every test; the first one tells of all, the others of their failures.
#include <gtest/gtest.h>
#include <petscsys.h>

int main(int argc, char** argv) {
  if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0) return 1;
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank > 0) GTEST_FLAG_SET(brief, true);
  testing::InitGoogleTest(&argc, argv);
  const int failed = RUN_ALL_TESTS();
  return PetscFinalize() == 0 ? failed : 1;
}
