#pragma once
/// Messages of bytes from process to process. A run over several ranks needs no more of MPI than this interface.
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
  virtual int threads() const = 0;  ///< threads that this rank may use: its share of the cores of the machine
  /// Returns when the caller may free `bytes`. Throws IoError if they are too long for one message.
  virtual void send(int to, const std::string& bytes) = 0;
  /// The next message, if one is there.
  virtual std::optional<Message> try_receive() = 0;
  /// Ends all ranks at once, when one of them cannot even send a message about its error.
  [[noreturn]] virtual void abort(int exit) = 0;
  /// Waits for the next message. Sleeps meanwhile, to leave the cores to the computing threads.
  Message receive();
};

}  // namespace surveymc::montecarlo
