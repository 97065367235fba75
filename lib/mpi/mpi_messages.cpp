#include "mpi/mpi_messages.h"

#include <sched.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>
#include <mpi.h>

#include "base/error.h"

namespace surveymc::mpi {
namespace {

/// Ranks that mpirun has bound to cores have these; ranks that may run anywhere divide the cores of their machine.
int share_of_cores() {
  cpu_set_t mine;
  CPU_ZERO(&mine);
  if (sched_getaffinity(0, sizeof mine, &mine) != 0) return 1;
  std::array<int, CPU_SETSIZE> ours{}, of_all{};
  for (std::size_t core = 0; core < ours.size(); ++core) ours[core] = CPU_ISSET(core, &mine) ? 1 : 0;
  MPI_Comm here;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here);
  MPI_Allreduce(ours.data(), of_all.data(), CPU_SETSIZE, MPI_INT, MPI_SUM, here);
  MPI_Comm_free(&here);
  double share = 0;
  for (std::size_t core = 0; core < ours.size(); ++core)
    if (ours[core]) share += 1.0 / of_all[core];
  return std::max(1, static_cast<int>(share + 1e-6));
}

class MpiMessages : public montecarlo::Messages {
 public:
  MpiMessages(int& argc, char**& argv) {
    int provided = MPI_THREAD_SINGLE;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
    if (provided < MPI_THREAD_SERIALIZED) {
      MPI_Finalize();
      throw std::runtime_error("this MPI library allows no threads (MPI_THREAD_SERIALIZED)");
    }
    threads_ = share_of_cores();
  }
  ~MpiMessages() override { MPI_Finalize(); }

  int rank() const override { return rank_; }
  int count() const override { return count_; }
  int threads() const override { return threads_; }

  void send(int to, const std::string& bytes) override {
    if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
      throw IoError(
          fmt::format("a message of {} bytes from rank {} to rank {} is too long for MPI: use parts instead "
                      "(docs/cluster.md)",
                      bytes.size(), rank_, to));
    MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, to, 0, MPI_COMM_WORLD);
  }

  std::optional<montecarlo::Message> try_receive() override {
    int there = 0;
    MPI_Status status;
    MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &there, &status);
    if (!there) return std::nullopt;
    int size = 0;
    MPI_Get_count(&status, MPI_BYTE, &size);
    montecarlo::Message m{status.MPI_SOURCE, std::string(static_cast<std::size_t>(size), '\0')};
    MPI_Recv(m.bytes.data(), size, MPI_BYTE, m.from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    return m;
  }

  [[noreturn]] void abort(int exit) override {
    MPI_Abort(MPI_COMM_WORLD, exit);
    std::abort();
  }

 private:
  int rank_ = 0, count_ = 1, threads_ = 1;
};

}  // namespace

std::unique_ptr<montecarlo::Messages> mpi_messages(int& argc, char**& argv) {
  return std::make_unique<MpiMessages>(argc, argv);
}

std::string mpi_version() {
  char text[MPI_MAX_LIBRARY_VERSION_STRING] = "";
  int length = 0;
  MPI_Get_library_version(text, &length);
  const std::string all(text, static_cast<std::size_t>(length));
  return all.substr(0, all.find_first_of(",\n"));
}

}  // namespace surveymc::mpi
