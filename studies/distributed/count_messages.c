/* Counts what each rank of an MPI program sends, hypre's messages too: a library to preload.
   mpicc -O2 -shared -fPIC -o count_messages.so count_messages.c
   mpirun -n 4 -x LD_PRELOAD=$PWD/count_messages.so kappamu-mpi bench ...
   At the end rank 0 prints, over all ranks: messages and bytes of the rank that sends most, reductions of a rank. */
#include <mpi.h>
#include <stdio.h>

static double messages, bytes, reductions;

static void count(int items, MPI_Datatype type) {
  int size = 0;
  PMPI_Type_size(type, &size);
  messages += 1;
  bytes += (double)size * items;
}

int MPI_Isend(const void* data, int items, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  count(items, type);
  return PMPI_Isend(data, items, type, to, tag, comm, request);
}

int MPI_Send(const void* data, int items, MPI_Datatype type, int to, int tag, MPI_Comm comm) {
  count(items, type);
  return PMPI_Send(data, items, type, to, tag, comm);
}

int MPI_Start(MPI_Request* request) {
  messages += 1; /* of persistent requests the bytes are not known here */
  return PMPI_Start(request);
}

int MPI_Startall(int requests, MPI_Request* first) {
  messages += 0.5 * requests; /* as many receive as send */
  return PMPI_Startall(requests, first);
}

int MPI_Allreduce(const void* in, void* out, int items, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  reductions += 1;
  return PMPI_Allreduce(in, out, items, type, op, comm);
}

int MPI_Finalize(void) {
  double mine[3] = {messages, bytes, reductions}, most[3];
  int rank = 0;
  PMPI_Reduce(mine, most, 3, MPI_DOUBLE, MPI_MAX, 0, MPI_COMM_WORLD);
  PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) fprintf(stderr, "sent: %.0f messages, %.0f bytes, %.0f reductions\n", most[0], most[1], most[2]);
  return PMPI_Finalize();
}
