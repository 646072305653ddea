#include "ranks/mpi_link.h"

#include <mpi.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <cstdlib>

#include "base/status.h"

namespace fb::tool {
namespace {

int checked_size(const Bytes& bytes) {
  if (bytes.size() > INT_MAX) fail(Status::limit, "a message of %zu bytes is too long for MPI", bytes.size());
  return static_cast<int>(bytes.size());
}

std::uint32_t threads_of_rank() {
  MPI_Comm machine;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  int ranks = 1;
  MPI_Comm_size(machine, &ranks);
  MPI_Comm_free(&machine);
  if (const char* told = std::getenv("OMP_NUM_THREADS"))
    if (const int threads = std::atoi(told); threads > 0) return static_cast<std::uint32_t>(threads);
  const long all = ::sysconf(_SC_NPROCESSORS_ONLN);
  cpu_set_t processors;
  const int ours = ::sched_getaffinity(0, sizeof processors, &processors) == 0 ? CPU_COUNT(&processors) : 1;
  return static_cast<std::uint32_t>(std::max(1, ours < all ? ours : ours / ranks));
}

}  // namespace

struct MpiLink::Posted {
  Bytes bytes;
  MPI_Request request;
};

MpiLink::MpiLink(int* argc, char*** argv) {
  int level = 0, rank = 0, size = 1;
  MPI_Init_thread(argc, argv, MPI_THREAD_SERIALIZED, &level);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  rank_ = static_cast<std::size_t>(rank);
  size_ = static_cast<std::size_t>(size);
  threads_ = threads_of_rank();
  if (level >= MPI_THREAD_SERIALIZED) return;
  MPI_Finalize();
  fail(Status::unsupported, "this MPI cannot be used by threads in turn (MPI_THREAD_SERIALIZED)");
}

MpiLink::~MpiLink() {
  for (Posted& posted : posted_) MPI_Wait(&posted.request, MPI_STATUS_IGNORE);
  MPI_Finalize();
}

void MpiLink::send(std::size_t rank, RankTag tag, const Bytes& bytes) {
  MPI_Send(bytes.data(), checked_size(bytes), MPI_BYTE, static_cast<int>(rank), static_cast<int>(tag), MPI_COMM_WORLD);
}

void MpiLink::post(std::size_t rank, RankTag tag, Bytes bytes) {
  const int size = checked_size(bytes);
  Posted& posted = posted_.emplace_back(Posted{std::move(bytes), MPI_REQUEST_NULL});
  MPI_Isend(posted.bytes.data(), size, MPI_BYTE, static_cast<int>(rank), static_cast<int>(tag), MPI_COMM_WORLD,
            &posted.request);
}

std::optional<RankMessage> MpiLink::poll(std::optional<RankTag> tag) {
  posted_.remove_if([](Posted& posted) {
    int sent = 0;
    MPI_Test(&posted.request, &sent, MPI_STATUS_IGNORE);
    return sent != 0;
  });
  int found = 0, size = 0;
  MPI_Message message;
  MPI_Status status;
  MPI_Improbe(MPI_ANY_SOURCE, tag ? static_cast<int>(*tag) : MPI_ANY_TAG, MPI_COMM_WORLD, &found, &message, &status);
  if (!found) return std::nullopt;
  MPI_Get_count(&status, MPI_BYTE, &size);
  RankMessage got = {static_cast<std::size_t>(status.MPI_SOURCE), static_cast<RankTag>(status.MPI_TAG),
                     Bytes(static_cast<std::size_t>(size))};
  MPI_Mrecv(got.bytes.data(), size, MPI_BYTE, &message, MPI_STATUS_IGNORE);
  return got;
}

}  // namespace fb::tool
