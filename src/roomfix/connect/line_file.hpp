// Files that are whole at any moment, whatever ends the program: written beside their name first, or growing by whole lines.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "roomfix/base/result.hpp"

namespace roomfix {

/// The file appears with all of its bytes, or not at all. The error says why and what to do.
Result<void> write_whole(const std::filesystem::path& file, std::span<const std::uint8_t> bytes);
Result<void> write_whole(const std::filesystem::path& file, std::string_view text);

/// A text file that grows. Lines wait in memory until they are flushed.
class LineFile {
public:
    /// A new file of these lines, each with its end; an older one of that name is replaced.
    static Result<LineFile> create(const std::filesystem::path& file, std::string_view first_lines);
    ~LineFile();
    LineFile(LineFile&& other) noexcept;
    LineFile& operator=(LineFile&& other) noexcept;

    /// A line with its end.
    void add(std::string_view line);
    /// Writes what waits. Where the disk takes only a part of it, that part is taken back and all of it waits on, up to a limit: what is beyond is
    /// lost and counted.
    Result<void> flush();
    bool waits() const { return !waiting_.empty(); }
    std::int64_t bytes() const { return bytes_; }
    long lost_lines() const { return lost_lines_; }
    /// That wait to be written.
    long waiting_lines() const;

private:
    LineFile(std::filesystem::path file, int descriptor, std::int64_t bytes) : path_(std::move(file)), descriptor_(descriptor), bytes_(bytes) {}

    std::filesystem::path path_;
    int descriptor_ = -1;
    std::int64_t bytes_ = 0;  // that the file has
    std::string waiting_;
    long lost_lines_ = 0;
};

}  // namespace roomfix
