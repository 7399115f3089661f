// Pictures out of an HTTP answer that never ends (multipart/x-mixed-replace, what cameras call MJPEG).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomfix/base/result.hpp"

namespace roomfix {

struct MultipartPart {
    std::vector<std::uint8_t> body;
    std::optional<double> timestamp;  // s: the part's header X-Timestamp
    double began = 0;                 // s: when its first bytes came
};

/// Takes bytes as they come. The boundary is learned from the first line that begins with two dashes, since cameras state it in many ways.
class MultipartReader {
public:
    /// Bytes that came at a time (s). An error if they cannot be such a stream: the reader is of no use then.
    Result<void> feed(std::span<const std::uint8_t> bytes, double time);
    /// The next part that is whole.
    std::optional<MultipartPart> take();

private:
    enum class State { boundary, headers, sized_body, open_body };
    bool step();
    bool read_boundary();
    bool read_headers();
    bool read_sized_body();
    bool read_open_body();
    void note_begin();
    void read_header(std::string_view line);
    void finish_body(std::size_t size);
    std::string_view rest() const;

    State state_ = State::boundary;
    std::vector<std::uint8_t> buffer_;
    std::size_t from_ = 0;      // of the buffer: what is before it has been used
    std::size_t searched_ = 0;  // of the rest: up to there, no end of the body
    std::string boundary_;      // with its dashes; empty: not known yet
    std::size_t size_ = 0;      // of the body, as its header states
    double time_ = 0;
    bool began_ = false;  // a byte of the body has come
    MultipartPart part_;
    std::vector<MultipartPart> whole_;
    std::string problem_;
};

}  // namespace roomfix
