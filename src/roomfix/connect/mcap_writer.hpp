// Recordings in the format MCAP (https://mcap.dev/spec): messages in chunks with their index, attachments, statistics, checksums throughout.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/base/time.hpp"
#include "roomfix/connect/crc32.hpp"
#include "roomfix/connect/little_endian.hpp"

namespace roomfix {

struct McapSchema {
    std::string name;      // "geometry_msgs/msg/Point"
    std::string encoding;  // "ros2msg"
    std::string text;
};

struct McapChannel {
    std::string topic;
    std::string encoding;  // of its messages: "cdr"
    std::uint16_t schema = 0;
    std::map<std::string, std::string> metadata;
};

struct McapAttachment {
    std::string name;
    std::string media_type;
    std::string content;
    Nanoseconds time = 0;  // not before 1970
};

class McapWriter {
public:
    /// Begins the file, in place of one of that name. `profile` says by which rules channels and schemas are named: "ros2", or empty.
    static Result<std::unique_ptr<McapWriter>> create(const std::filesystem::path& file, const std::string& profile);

    std::uint16_t add_schema(const McapSchema& schema);
    /// An error where there are too many.
    Result<std::uint16_t> add_channel(const McapChannel& channel);
    /// Times are not before 1970. Errors: the file cannot be written on.
    Result<void> write(std::uint16_t channel, Nanoseconds time, std::span<const std::uint8_t> message);
    Result<void> attach(const McapAttachment& attachment);
    /// Index and end of the file. Nothing may be written after it.
    Result<void> finish();
    /// Instead of finishing: what was written is removed.
    void abandon();

    std::uint64_t message_count() const;
    std::uint64_t message_count(std::uint16_t channel) const;
    /// Of the first and the last message; 0 without any.
    Nanoseconds start_time() const { return start_; }
    Nanoseconds end_time() const { return end_; }

private:
    struct IndexEntry {
        std::uint64_t time = 0, offset = 0;
    };
    struct ChunkIndex {
        std::uint64_t start = 0, end = 0, offset = 0, length = 0, index_length = 0, size = 0;
        std::map<std::uint16_t, std::uint64_t> index_offsets;
    };
    struct AttachmentIndex {
        std::uint64_t offset = 0, length = 0, time = 0, size = 0;
        std::string name, media_type;
    };
    explicit McapWriter(std::filesystem::path file) : path_(std::move(file)) {}
    Bytes schema_record(std::size_t index) const;
    Bytes channel_record(std::size_t index) const;
    Bytes statistics_record() const;
    Bytes summary() const;
    Result<void> put(std::span<const std::uint8_t> bytes);
    Result<void> end_chunk();
    void put_chunk_index(const ChunkIndex& chunk, Bytes& summary) const;

    std::filesystem::path path_;
    std::ofstream file_;
    std::uint64_t offset_ = 0;           // bytes written
    Crc32 sum_;                          // of all of them
    std::vector<McapSchema> schemas_;    // their ids count from 1
    std::vector<McapChannel> channels_;  // likewise
    std::vector<std::uint64_t> counts_;  // messages of each channel
    Bytes chunk_;                        // records that are not written yet
    std::map<std::uint16_t, std::vector<IndexEntry>> chunk_messages_;
    Nanoseconds chunk_start_ = 0, chunk_end_ = 0, start_ = 0, end_ = 0;
    std::vector<ChunkIndex> chunks_;
    std::vector<AttachmentIndex> attachments_;
};

}  // namespace roomfix
