#include "cli/signals.h"

#include <pthread.h>
#include <semaphore.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <mutex>
#include <system_error>
#include <thread>

#include <fmt/format.h>

#include "cli/exit_codes.h"
#include "cli/screen.h"
#include "store/atomic_file.h"

namespace surveymc::cli {
namespace {

std::atomic<bool> g_stop = false;  // set by a signal handler, read at block boundaries
sem_t g_signalled;                 // posted by it, for the thread that waits
extern "C" void on_signal(int) {
  g_stop = true;
  sem_post(&g_signalled);
}

/// The EndsBySignal that lives, if there is one.
struct PermissionToEnd {
  std::mutex changing;
  bool given = false;
  checkpoint::Journal* journal = nullptr;
  EndMessage message;
};
PermissionToEnd& permission_to_end() {
  static PermissionToEnd& one = *new PermissionToEnd;  // the waiting thread outlives main()
  return one;
}

/// Ends the program, if it may be ended so long after the signal.
void end_program(std::chrono::milliseconds waited) {
  PermissionToEnd& p = permission_to_end();
  const std::scoped_lock lock(p.changing);
  if (!p.given || waited.count() < p.message.after_ms) return;
  const bool kept = p.journal && p.journal->sync() && p.journal->is_there();
  const std::string text = fmt::format("{}interrupted: {}\n", isatty(STDERR_FILENO) ? "\r\033[K" : "",
                                       printable_lines(kept ? p.message.kept : p.message.nothing));
  store::AtomicFile::remove_all();
  [[maybe_unused]] const ssize_t n = write(STDERR_FILENO, text.data(), text.size());
  _exit(kInterrupted);
}

void wait_for_signal() {
  constexpr auto kAgain = std::chrono::milliseconds(20);
  while (sem_wait(&g_signalled) != 0) {
  }
  const auto signalled = std::chrono::steady_clock::now();
  for (;; std::this_thread::sleep_for(kAgain))
    end_program(std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - signalled));
}

}  // namespace

void catch_signals() {
  sem_init(&g_signalled, 0, 0);
  sigset_t all, before;  // the waiting thread gets no signals
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  try {
    std::thread(wait_for_signal).detach();
  } catch (const std::system_error&) {  // no more threads: then the stop flag has to do
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1, SIGALRM}) std::signal(signal, on_signal);
  for (const int signal : {SIGHUP, SIGXCPU})  // the terminal is gone; a limit of processor time is near
    if (std::signal(signal, on_signal) == SIG_IGN) std::signal(signal, SIG_IGN);  // nohup
}

EndsBySignal::EndsBySignal(checkpoint::Journal* journal, EndMessage message) {
  PermissionToEnd& p = permission_to_end();
  const std::scoped_lock lock(p.changing);
  p.journal = journal;
  p.message = std::move(message);
  p.given = true;
}

EndsBySignal::~EndsBySignal() {
  const std::scoped_lock lock(permission_to_end().changing);
  permission_to_end().given = false;
}

const std::atomic<bool>* stop_flag() { return &g_stop; }

void stop_after(double seconds) {
  if (seconds <= 0) return;
  constexpr double kLongest = 1e9;
  const double whole = std::min(seconds, kLongest);
  itimerval timer{};
  timer.it_value.tv_sec = static_cast<time_t>(whole);
  timer.it_value.tv_usec = static_cast<suseconds_t>((whole - static_cast<double>(timer.it_value.tv_sec)) * 1e6) + 1;
  if (timer.it_value.tv_usec > 999'999) timer.it_value.tv_usec = 999'999;
  setitimer(ITIMER_REAL, &timer, nullptr);
}

}  // namespace surveymc::cli
