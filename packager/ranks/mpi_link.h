#pragma once

#include <cstdint>
#include <list>

#include "ranks/rank_link.h"

namespace fb::tool {

// The ranks of an MPI job, from MPI_Init to MPI_Finalize. A program that is not started by mpirun or srun is the only
// rank. mpi_link.cpp alone knows MPI; its errors end the job, as is MPI's default.
class MpiLink final : public RankLink {
 public:
  MpiLink(int* argc, char*** argv);
  // Returns once all ranks have come here.
  ~MpiLink() override;
  MpiLink(const MpiLink&) = delete;
  MpiLink& operator=(const MpiLink&) = delete;

  std::size_t rank() const override { return rank_; }
  std::size_t size() const override { return size_; }
  void send(std::size_t rank, RankTag tag, const Bytes& bytes) override;
  void post(std::size_t rank, RankTag tag, Bytes bytes) override;
  std::optional<RankMessage> poll(std::optional<RankTag> tag) override;

  // Threads on which this rank should evaluate: OMP_NUM_THREADS, the processors that mpirun has bound it to, or its
  // share of the machine's.
  std::uint32_t threads() const { return threads_; }

 private:
  struct Posted;

  std::size_t rank_ = 0, size_ = 1;
  std::uint32_t threads_ = 1;
  std::list<Posted> posted_;
};

}  // namespace fb::tool
