// Ctrl-C, SIGTERM and SIGHUP: ask running work to stop, so that it can tidy up.
#pragma once

namespace octavo::cli {

/// Takes over SIGINT, SIGTERM and, unless it is ignored already, SIGHUP; ignores SIGPIPE and
/// SIGXFSZ, which become errors of the write that met them. A signal ends the program at once with
/// 128 + signal, except while a CancellableWork lives: then the first one only asks the work to
/// stop.
void install_signal_handlers();

/// True once a signal asked running work to stop.
bool is_cancel_requested() noexcept;

/// The signal that asked; SIGINT when none did.
int cancelling_signal() noexcept;

/// Marks the time in which a signal must not end the program at once.
class CancellableWork {
 public:
  CancellableWork();
  ~CancellableWork();
  CancellableWork(const CancellableWork&) = delete;
  CancellableWork& operator=(const CancellableWork&) = delete;
};

}  // namespace octavo::cli
