#include "interrupt.h"

#include <csignal>

namespace lumisweep::cli {

namespace {

volatile std::sig_atomic_t interrupt_flag = 0; // a signal handler can reach nothing else

void note_interrupt(int) { interrupt_flag = 1; }

} // namespace

void catch_interrupts()
{
    struct sigaction action = {};
    action.sa_handler = note_interrupt;
    sigemptyset(&action.sa_mask);
    action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() { return interrupt_flag != 0; }

} // namespace lumisweep::cli
