# Finds MPI::MPI_CXX. Debian's openmpi-bin, which others depend on, brings the wrapper without the header, and FindMPI ends
# the configuration there: so ask the wrapper first.
find_program(MPI_CXX_COMPILER NAMES mpicxx mpic++)
if(MPI_CXX_COMPILER)
  file(WRITE ${CMAKE_BINARY_DIR}/has_mpi.cpp "#include <mpi.h>\n")
  execute_process(COMMAND ${MPI_CXX_COMPILER} -fsyntax-only ${CMAKE_BINARY_DIR}/has_mpi.cpp
    RESULT_VARIABLE mpi_status OUTPUT_QUIET ERROR_QUIET)
  if(mpi_status EQUAL 0)
    find_package(MPI COMPONENTS CXX QUIET)
  endif()
endif()
