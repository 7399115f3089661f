#include "roomfix/connect/mcap_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "roomfix/version.hpp"

namespace roomfix {
namespace {

constexpr std::size_t chunk_size = std::size_t{1} << 18;  // bytes: a chunk that is larger is written
constexpr std::array<std::uint8_t, 8> magic = {0x89, 'M', 'C', 'A', 'P', 0x30, '\r', '\n'};

/// Kinds of records, by the numbers of the format.
enum class Opcode : std::uint8_t {
    header = 0x01,
    footer = 0x02,
    schema = 0x03,
    channel = 0x04,
    message = 0x05,
    chunk = 0x06,
    message_index = 0x07,
    chunk_index = 0x08,
    attachment = 0x09,
    attachment_index = 0x0a,
    statistics = 0x0b,
    summary_offset = 0x0e,
    data_end = 0x0f,
};

/// Its length before it.
void append_string(Bytes& bytes, std::string_view text) {
    append(bytes, static_cast<std::uint32_t>(text.size()));
    append_text(bytes, text);
}

/// Maps and arrays have their length in bytes before them.
void append_list(Bytes& bytes, const Bytes& entries) {
    append(bytes, static_cast<std::uint32_t>(entries.size()));
    bytes.insert(bytes.end(), entries.begin(), entries.end());
}

void append_record(Bytes& bytes, Opcode opcode, const Bytes& content) {
    bytes.push_back(static_cast<std::uint8_t>(opcode));
    append(bytes, static_cast<std::uint64_t>(content.size()));
    bytes.insert(bytes.end(), content.begin(), content.end());
}

Bytes record(Opcode opcode, const Bytes& content) {
    Bytes bytes;
    append_record(bytes, opcode, content);
    return bytes;
}

/// All of one kind in the summary.
struct Group {
    Opcode opcode;
    std::size_t start, length;  // bytes, in the summary
};

}  // namespace

Result<std::unique_ptr<McapWriter>> McapWriter::create(const std::filesystem::path& file, const std::string& profile) {
    std::unique_ptr<McapWriter> writer(new McapWriter(file));
    writer->file_.open(file, std::ios::binary | std::ios::trunc);
    if (!writer->file_) return Error{fmt::format("{}: cannot be written: does the folder exist, and may you write there?", file.string())};
    Bytes beginning(magic.begin(), magic.end());
    Bytes header;
    append_string(header, profile);
    append_string(header, std::string("roomfix ") + version);
    append_record(beginning, Opcode::header, header);
    if (auto written = writer->put(beginning); !written) return written.error();
    return writer;
}

Result<void> McapWriter::put(std::span<const std::uint8_t> bytes) {
    file_.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    sum_.add(bytes);
    offset_ += bytes.size();
    if (file_) return {};
    return Error{fmt::format("{}: cannot be written on: is the disk full?", path_.string())};
}

std::uint16_t McapWriter::add_schema(const McapSchema& schema) {
    schemas_.push_back(schema);
    const Bytes bytes = schema_record(schemas_.size() - 1);
    chunk_.insert(chunk_.end(), bytes.begin(), bytes.end());
    return static_cast<std::uint16_t>(schemas_.size());
}

Result<std::uint16_t> McapWriter::add_channel(const McapChannel& channel) {
    if (channels_.size() == 0xffff) return Error{fmt::format("{}: more than {} topics do not fit into one recording", path_.string(), channels_.size())};
    channels_.push_back(channel);
    counts_.push_back(0);
    const Bytes bytes = channel_record(channels_.size() - 1);
    chunk_.insert(chunk_.end(), bytes.begin(), bytes.end());
    return static_cast<std::uint16_t>(channels_.size());
}

Bytes McapWriter::schema_record(std::size_t index) const {
    Bytes content;
    append(content, static_cast<std::uint16_t>(index + 1));
    append_string(content, schemas_[index].name);
    append_string(content, schemas_[index].encoding);
    append_string(content, schemas_[index].text);
    return record(Opcode::schema, content);
}

Bytes McapWriter::channel_record(std::size_t index) const {
    const McapChannel& channel = channels_[index];
    Bytes content, metadata;
    append(content, static_cast<std::uint16_t>(index + 1));
    append(content, channel.schema);
    append_string(content, channel.topic);
    append_string(content, channel.encoding);
    for (const auto& [key, value] : channel.metadata) {
        append_string(metadata, key);
        append_string(metadata, value);
    }
    append_list(content, metadata);
    return record(Opcode::channel, content);
}

Result<void> McapWriter::write(std::uint16_t channel, Nanoseconds time, std::span<const std::uint8_t> message) {
    const bool first_in_chunk = chunk_messages_.empty(), first = first_in_chunk && chunks_.empty();
    chunk_start_ = first_in_chunk ? time : std::min(chunk_start_, time);
    chunk_end_ = first_in_chunk ? time : std::max(chunk_end_, time);
    start_ = first ? time : std::min(start_, time);
    end_ = first ? time : std::max(end_, time);
    std::uint64_t& count = counts_[channel - 1U];
    const auto stamp = static_cast<std::uint64_t>(time);
    chunk_messages_[channel].push_back({stamp, chunk_.size()});
    Bytes content;
    append(content, channel);
    append(content, static_cast<std::uint32_t>(count++));
    append(content, stamp);  // when it was recorded
    append(content, stamp);  // when it was sent
    content.insert(content.end(), message.begin(), message.end());
    append_record(chunk_, Opcode::message, content);
    return chunk_.size() < chunk_size ? Result<void>() : end_chunk();
}

Result<void> McapWriter::end_chunk() {
    if (chunk_.empty()) return {};
    ChunkIndex index{static_cast<std::uint64_t>(chunk_start_), static_cast<std::uint64_t>(chunk_end_), offset_};
    index.size = chunk_.size();
    Bytes content;
    append(content, index.start);
    append(content, index.end);
    append(content, index.size);
    append(content, crc32(chunk_));
    append_string(content, "");  // not compressed
    append(content, index.size);
    content.insert(content.end(), chunk_.begin(), chunk_.end());
    Bytes bytes = record(Opcode::chunk, content);
    index.length = bytes.size();
    for (const auto& [channel, messages] : chunk_messages_) {
        index.index_offsets[channel] = offset_ + bytes.size();
        Bytes entries, message_index;
        for (const IndexEntry& entry : messages) {
            append(entries, entry.time);
            append(entries, entry.offset);
        }
        append(message_index, channel);
        append_list(message_index, entries);
        append_record(bytes, Opcode::message_index, message_index);
    }
    index.index_length = bytes.size() - index.length;
    chunks_.push_back(index);
    chunk_.clear();
    chunk_messages_.clear();
    chunk_start_ = chunk_end_ = 0;
    return put(bytes);
}

Result<void> McapWriter::attach(const McapAttachment& attachment) {
    const auto stamp = static_cast<std::uint64_t>(attachment.time);
    Bytes content;
    append(content, stamp);
    append(content, stamp);
    append_string(content, attachment.name);
    append_string(content, attachment.media_type);
    append(content, static_cast<std::uint64_t>(attachment.content.size()));
    append_text(content, attachment.content);
    append(content, crc32(content));
    const Bytes bytes = record(Opcode::attachment, content);
    attachments_.push_back({offset_, bytes.size(), stamp, attachment.content.size(), attachment.name, attachment.media_type});
    return put(bytes);
}

Bytes McapWriter::statistics_record() const {
    Bytes content, counts;
    append(content, message_count());
    append(content, static_cast<std::uint16_t>(schemas_.size()));
    append(content, static_cast<std::uint32_t>(channels_.size()));
    append(content, static_cast<std::uint32_t>(attachments_.size()));
    append(content, std::uint32_t{0});  // records of metadata
    append(content, static_cast<std::uint32_t>(chunks_.size()));
    append(content, static_cast<std::uint64_t>(start_));
    append(content, static_cast<std::uint64_t>(end_));
    for (std::size_t i = 0; i < counts_.size(); ++i) {
        append(counts, static_cast<std::uint16_t>(i + 1));
        append(counts, counts_[i]);
    }
    append_list(content, counts);
    return record(Opcode::statistics, content);
}

void McapWriter::put_chunk_index(const ChunkIndex& chunk, Bytes& summary) const {
    Bytes content, offsets;
    for (const std::uint64_t value : {chunk.start, chunk.end, chunk.offset, chunk.length}) append(content, value);
    for (const auto& [channel, offset] : chunk.index_offsets) {
        append(offsets, channel);
        append(offsets, offset);
    }
    append_list(content, offsets);
    append(content, chunk.index_length);
    append_string(content, "");
    append(content, chunk.size);
    append(content, chunk.size);
    append_record(summary, Opcode::chunk_index, content);
}

/// What comes behind the data, up to the footer's checksum.
Bytes McapWriter::summary() const {
    Bytes bytes;
    std::vector<Group> groups;
    const auto add_group = [&](Opcode opcode, std::size_t count, const auto& add) {
        const std::size_t start = bytes.size();
        for (std::size_t i = 0; i < count; ++i) add(i);
        if (count > 0) groups.push_back({opcode, start, bytes.size() - start});
    };
    const auto add_bytes = [&](const Bytes& more) { bytes.insert(bytes.end(), more.begin(), more.end()); };
    add_group(Opcode::schema, schemas_.size(), [&](std::size_t i) { add_bytes(schema_record(i)); });
    add_group(Opcode::channel, channels_.size(), [&](std::size_t i) { add_bytes(channel_record(i)); });
    add_group(Opcode::statistics, 1, [&](std::size_t) { add_bytes(statistics_record()); });
    add_group(Opcode::chunk_index, chunks_.size(), [&](std::size_t i) { put_chunk_index(chunks_[i], bytes); });
    add_group(Opcode::attachment_index, attachments_.size(), [&](std::size_t i) {
        const AttachmentIndex& a = attachments_[i];
        Bytes content;
        for (const std::uint64_t value : {a.offset, a.length, a.time, a.time, a.size}) append(content, value);
        append_string(content, a.name);
        append_string(content, a.media_type);
        append_record(bytes, Opcode::attachment_index, content);
    });
    const std::uint64_t offsets = offset_ + bytes.size();
    for (const Group& group : groups) {
        Bytes content = {static_cast<std::uint8_t>(group.opcode)};
        append(content, offset_ + group.start);
        append(content, static_cast<std::uint64_t>(group.length));
        append_record(bytes, Opcode::summary_offset, content);
    }
    bytes.push_back(static_cast<std::uint8_t>(Opcode::footer));
    constexpr std::uint64_t footer_length = 20;
    for (const std::uint64_t value : {footer_length, offset_, offsets}) append(bytes, value);
    return bytes;
}

Result<void> McapWriter::finish() {
    if (auto written = end_chunk(); !written) return written;
    Bytes sum;
    append(sum, sum_.value());
    if (auto written = put(record(Opcode::data_end, sum)); !written) return written;
    Bytes end = summary();
    append(end, crc32(end));
    end.insert(end.end(), magic.begin(), magic.end());
    if (auto written = put(end); !written) return written;
    file_.close();
    if (file_) return {};
    return Error{fmt::format("{}: cannot be written on: is the disk full?", path_.string())};
}

void McapWriter::abandon() {
    file_.close();
    std::error_code failure;
    if (std::filesystem::is_regular_file(path_, failure)) std::filesystem::remove(path_, failure);
}

std::uint64_t McapWriter::message_count() const {
    std::uint64_t all = 0;
    for (const std::uint64_t count : counts_) all += count;
    return all;
}

std::uint64_t McapWriter::message_count(std::uint16_t channel) const { return counts_[channel - 1U]; }

}  // namespace roomfix
