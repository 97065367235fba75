#include "montecarlo/workers.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>

#include "base/bytes.h"
#include "base/error.h"

namespace surveymc::montecarlo {
namespace {

// First byte of a message; the comment says what follows
enum Kind : char {
  kOrder = 'o',   // BlockOrder
  kStop = 's',    // nothing
  kEnd = 'e',     // exit code
  kDone = 'd',    // subtrees: the whole share
  kCut = 'c',     // subtrees: what was done before a stop
  kInput = 'i',   // text of an InputError
  kIo = 'f',      // text of an IoError
  kFailed = 'x',  // text of another exception
};

std::string message(Kind kind, std::string body = {}) { return std::string(1, kind) + body; }

// Bodies, for bytes_of() and value_from()

constexpr auto kOrderFields = [](auto& bytes, auto& order) {
  bytes.fields(order.run, order.journal, order.point);
  bytes.length_of(16, order.blocks);
  for (auto& r : order.blocks) bytes.fields(r.first, r.end);
};

constexpr auto kSubtreeFields = [](auto& bytes, auto& nodes) { subtree_fields(bytes, nodes); };

/// Sleeps a little, to leave the cores to the computing threads.
void sleep_briefly() { std::this_thread::sleep_for(std::chrono::microseconds(500)); }

int exit_code(std::string_view body) { return ByteReader(body).get<std::int32_t>(); }

}  // namespace

Message Messages::receive() {
  for (;;) {
    if (std::optional<Message> m = try_receive()) return std::move(*m);
    sleep_briefly();
  }
}

std::uint64_t Workers::least_piece() const {
  return messages_ ? static_cast<std::uint64_t>(std::max(1, messages_->threads())) : 1;
}

void Workers::order(std::uint64_t point, std::size_t worker, const std::vector<BlockRange>& blocks) {
  messages_->send(static_cast<int>(worker) + 1,
                  message(kOrder, bytes_of(BlockOrder{run, journal, point, blocks}, kOrderFields)));
  ++open_;
}

void Workers::take(const Message& m) {
  --open_;
  const std::string_view body = std::string_view(m.bytes).substr(1);
  const char kind = m.bytes[0];
  if (kind != kDone) stop();
  if (kind == kDone || kind == kCut) {
    for (Subtree& n : value_from<std::vector<Subtree>>(body, kSubtreeFields)) work_.subtrees.push_back(std::move(n));
    if (kind == kCut) work_.cut_short = true;
  } else if (error_.empty()) {
    error_ = fmt::format("{}rank {}: {}", kind, m.from, body);
  }
}

bool Workers::poll(const std::function<void(std::size_t)>& is_free) {
  while (open_ > 0) {
    const std::optional<Message> m = messages_->try_receive();
    if (!m) break;
    take(*m);
    if (!stopped_) is_free(static_cast<std::size_t>(m->from) - 1);
  }
  return stopped_;
}

void Workers::stop() {
  if (stopped_) return;
  stopped_ = true;
  for (std::size_t w = 0; w < count(); ++w) messages_->send(static_cast<int>(w) + 1, message(kStop));
}

Workers::Work Workers::collect(const std::function<bool()>& stopped, const std::function<void(std::size_t)>& is_free) {
  for (; open_ > 0; sleep_briefly()) {
    if (stopped()) stop();
    poll(is_free);
  }
  Work work = std::move(work_);
  work_ = {};
  if (!error_.empty()) {
    const std::string text = error_.substr(1);
    if (error_[0] == kInput) throw InputError(text);
    if (error_[0] == kIo) throw IoError(text);
    throw std::runtime_error(text);
  }
  return work;
}

void Workers::end(int exit) {
  for (stop(); open_ > 0; sleep_briefly()) poll([](std::size_t) {});  // no rank may wait for us to receive its answer
  ByteWriter body;
  body.put(std::int32_t{exit});
  const std::string bytes = message(kEnd, body.take());
  for (std::size_t w = 0; w < count(); ++w) messages_->send(static_cast<int>(w) + 1, bytes);
}

namespace {

class Server {
 public:
  Server(Messages& messages, const std::function<Share(const BlockOrder&)>& share_of)
      : messages_(messages), share_of_(share_of) {}

  int run() {
    while (!exit_) {
      if (orders_.empty()) {
        take(messages_.receive());
      } else {
        const Message m = std::move(orders_.front());
        orders_.pop_front();
        reply(answer(value_from<BlockOrder>(std::string_view(m.bytes).substr(1), kOrderFields)));
      }
    }
    return *exit_;
  }

 private:
  void reply(const std::string& bytes) {
    try {
      messages_.send(0, bytes);
    } catch (const IoError& e) {  // too long
      messages_.send(0, message(kIo, e.what()));
    }
  }

  /// An order waits until those before it are done; anything else is to stop.
  void take(Message m) {
    if (m.bytes[0] == kOrder) {
      orders_.push_back(std::move(m));
      return;
    }
    told_ = true;
    if (m.bytes[0] == kEnd) exit_ = exit_code(std::string_view(m.bytes).substr(1));
  }

  std::string answer(const BlockOrder& order) {
    try {
      const Share share = share_of_(order);
      const RunOptions& options = share.options;
      OrderedMerge merge;
      const bool whole = compute_blocks(
          {order.blocks, share.trials, options.block_trials, options.threads}, share.kernel,
          [&] { return told_ || (options.stop && *options.stop); },
          [&](std::uint64_t block, stats::Tally tally) {
            merge.add(block, std::move(tally));
            if (options.save && options.save_due && options.save_due()) options.save(merge);
            if (std::optional<Message> m = messages_.try_receive()) take(std::move(*m));
          });
      if (options.save) options.save(merge);
      return message(whole ? kDone : kCut, bytes_of(merge.take(), kSubtreeFields));
    } catch (const Interrupted&) {  // before the first block
      return message(kCut, bytes_of(std::vector<Subtree>{}, kSubtreeFields));
    } catch (const InputError& e) {
      return message(kInput, e.what());
    } catch (const IoError& e) {
      return message(kIo, e.what());
    } catch (const std::exception& e) {
      return message(kFailed, e.what());
    }
  }

  Messages& messages_;
  const std::function<Share(const BlockOrder&)>& share_of_;
  std::deque<Message> orders_;
  std::atomic<bool> told_ = false;  // to stop
  std::optional<int> exit_;
};

}  // namespace

int serve(Messages& messages, const std::function<Share(const BlockOrder&)>& share_of) {
  return Server(messages, share_of).run();
}

}  // namespace surveymc::montecarlo
