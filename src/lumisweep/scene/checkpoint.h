// Checkpoints: a film on disk, with what it is the film of.
//
// The file is replaced at once (written beside, flushed to disk, renamed), so that a kill at any moment leaves the
// newest whole checkpoint. Layout, little-endian: "LUMICKPT", u32 format version, u32 header bytes, header (JSON:
// width, height, samples, fingerprint), the film's five arrays, u64 hash of everything before it.
#pragma once

#include <condition_variable>
#include <exception>
#include <filesystem>
#include <mutex>
#include <thread>

#include "lumisweep/render/film.h"
#include "lumisweep/scene/fingerprint.h"

namespace lumisweep {

/// Throws Error when the file cannot be written.
void write_checkpoint(const std::filesystem::path& file, const Film& film, const Fingerprint& fingerprint);

/// Throws Error for a file that is missing, no checkpoint, damaged, or of another render: then it says what differs.
Film read_checkpoint(const std::filesystem::path& file, const Fingerprint& expected);

/// Writes checkpoints beside rendering: copies the film, and a thread of its own writes the copy.
///
/// What a kill can lose is the pass under way and those that ended since the last write began. A write is begun after
/// each pass when the one before has ended and the processor time that writes take stays below 5 % of the time that has
/// passed; short passes are thereby grouped.
class CheckpointWriter {
public:
    CheckpointWriter(std::filesystem::path file, Fingerprint fingerprint);
    /// Waits for a write under way.
    ~CheckpointWriter();
    CheckpointWriter(const CheckpointWriter&) = delete;
    CheckpointWriter& operator=(const CheckpointWriter&) = delete;

    /// After a pass. Throws the Error of an earlier write that failed.
    void offer(const Film& film);
    /// Waits for what is under way, then writes `film` unless that was the last write. Throws Error when it cannot.
    void finish(const Film& film);

private:
    void write_pending();
    void rethrow_failure();

    std::filesystem::path file_;
    Fingerprint fingerprint_;
    std::mutex mutex_;
    std::condition_variable changed_;
    Film copy_;            // kept between writes, so that its pages are taken once
    bool pending_ = false; // copy_ is being written; the thread clears it
    bool ending_ = false;
    double write_cost_s_ = 0.0; // processor time of the last copy and write
    double last_begin_s_ = -1e300;
    std::exception_ptr failure_;
    std::thread thread_;
};

} // namespace lumisweep
