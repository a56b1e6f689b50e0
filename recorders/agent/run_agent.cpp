// SPDX-License-Identifier: MIT
#include "recorders/agent/run_agent.h"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <thread>

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr std::chrono::milliseconds kLookPeriod{100};
constexpr int kLooksAStatus = 50;

std::atomic<int> stop_signals{0};

// The first signal asks for an orderly end; the second takes the default way out.
void on_signal(int number) {
  const bool first = stop_signals.fetch_add(1) == 0;
  std::signal(number, first ? on_signal : SIG_DFL);  // Windows forgets the handler with every signal
  if (!first) std::raise(number);
}

std::string text_of(const AgentStatus& status) {
  const char* doing = !status.connected   ? "not connected"
                      : !status.recording ? "waiting for the recording"
                                          : "recording";
  char text[160];
  std::snprintf(text, sizeof text, "%s; %llu frames taken, %llu lost, %.1f MB waiting", doing,
                static_cast<unsigned long long>(status.frames_taken),
                static_cast<unsigned long long>(status.frames_lost),
                static_cast<double>(status.buffered_bytes) * 1e-6);
  return text;
}

// Shows how it goes and passes a signal on, until the link has ended.
class Watch {
 public:
  explicit Watch(AgentLink& link) : thread_([this, &link] { run(link); }) {}
  ~Watch() {
    ended_ = true;
    thread_.join();
  }

 private:
  void run(AgentLink& link) {
    std::string shown;
    for (int look = 1; !ended_; ++look) {
      if (stop_signals > 0) link.stop();
      if (look % kLooksAStatus == 0)
        if (const std::string text = text_of(link.status()); text != shown) {
          std::fprintf(stderr, "trilat-agent: %s\n", text.c_str());
          shown = text;
        }
      std::this_thread::sleep_for(kLookPeriod);
    }
  }
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

int end_of(const AgentReport& report) {
  if (!report.source_problem.empty())
    std::fprintf(stderr, "trilat-agent: the source broke: %s\n", report.source_problem.c_str());
  const auto taken = static_cast<unsigned long long>(report.status.frames_taken);
  const auto lost = static_cast<unsigned long long>(report.status.frames_lost);
  if (report.end == AgentEnd::unacknowledged && taken > 0) {
    std::fprintf(stderr,
                 "trilat-agent: the recording machine does not answer; not all of %llu frames arrived\n",
                 taken);
    return kFramesLost;
  }
  if (report.status.recordings_abandoned > 0)
    std::fprintf(stderr,
                 "trilat-agent: a recording that it took part in was broken off on the recording machine\n");
  std::fprintf(stderr, "trilat-agent: %s; %llu frames taken, %llu lost\n",
               report.end == AgentEnd::ended_by_server ? "the recording is over"
               : report.end == AgentEnd::abandoned     ? "nothing left to send"
                                                       : "done",
               taken, lost);
  const bool whole = lost == 0 && report.status.recordings_abandoned == 0 && report.source_problem.empty();
  return whole ? kDone : kFramesLost;
}

}  // namespace

int run_agent(FrameSource& source, AgentOptions options, const ConnectLink& connect) {
  options.incarnation =
      static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
  options.on_news = [](const std::string& news) { std::fprintf(stderr, "trilat-agent: %s\n", news.c_str()); };
  AgentLink link(source, options, connect);
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  const Watch watch(link);
  return end_of(link.run());
}

int guarded_agent_main(int (*body)(int, char**), int argc, char** argv) {
  try {
    return body(argc, argv);
  } catch (const InputError& error) {
    std::fprintf(stderr, "trilat-agent: %s\n", error.what());
    return kBadInput;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "trilat-agent: there is not enough memory\n");
    return kBadInput;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "trilat-agent: this is a bug of the program, please report it: %s\n", error.what());
    return kOurBug;
  }
}

}  // namespace trilat
