#pragma once
/// Bytes from process to process: all that a run over several ranks needs of MPI.
#include <optional>
#include <string>

namespace surveymc::montecarlo {

struct Message {
  int from = 0;
  std::string bytes;
};

/// Ranks 0 .. count() - 1. Messages from one rank to another arrive in order. Called by one thread at a time.
class Messages {
 public:
  virtual ~Messages() = default;
  virtual int rank() const = 0;
  virtual int count() const = 0;
  virtual int threads() const = 0;  ///< that this rank may use: its share of the cores that it and others may run on
  /// Returns when `bytes` may be forgotten. Throws IoError if they are too long for one message.
  virtual void send(int to, const std::string& bytes) = 0;
  /// The next message, if one is there.
  virtual std::optional<Message> try_receive() = 0;
  /// Ends all ranks at once, where one of them cannot even say what went wrong.
  [[noreturn]] virtual void abort(int exit) = 0;
  /// Waits for the next one. Sleeps meanwhile: the cores belong to those who compute.
  Message receive();
};

}  // namespace surveymc::montecarlo
