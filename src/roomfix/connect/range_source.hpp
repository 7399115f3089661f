// Ranges from files and serial lines.
#pragma once

#include <memory>
#include <string>

#include "roomfix/base/result.hpp"
#include "roomfix/ranging/range_reader.hpp"

namespace roomfix {

/// All ranges of a recorded file, in the order of their times: CSV, JSON lines, or a log of Cricket lines. Bad lines are in
/// `problems`, with the file's name. An error if the file cannot be read.
Result<RangeBatch> load_ranges(const std::string& file, const Site& site, int robot, int receiver = 0);

/// A serial line at 115200 baud, 8N1, raw: what a Cricket listener speaks.
class SerialLine {
public:
    /// An error says why the device cannot be opened and what to try.
    static Result<SerialLine> open(const std::string& device);
    ~SerialLine();
    SerialLine(SerialLine&& other) noexcept;
    SerialLine& operator=(SerialLine&&) = delete;

    /// Waits up to `seconds` for bytes and appends them. False when the device is gone.
    bool read(double seconds, std::string& bytes);

private:
    explicit SerialLine(int file) : file_(file) {}
    int file_;
};

}  // namespace roomfix
