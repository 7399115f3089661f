#include "roomfix/connect/libav_stream.hpp"

#include <fmt/format.h>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/imgutils.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

#include <array>
#include <chrono>
#include <cstring>
#include <utility>

#include "roomfix/base/steady_now.hpp"
#include "roomfix/connect/shown_address.hpp"

namespace roomfix {
namespace {

constexpr std::size_t largest_picture = 64 << 20;               // bytes
constexpr const char* microseconds_until_reordered = "100000";  // of packets that overtook one another (UDP)

std::string text_of(int code) {
    std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
    return av_strerror(code, text.data(), text.size()) == 0 ? text.data() : "unknown";
}

/// Ends calls of libav that take too long.
struct Watch {
    Patience patience;
    double seconds = 0;
    double until = 0;

    explicit Watch(const Patience& given) : patience(given) { start(given.to_open); }
    void start(double allowed) {
        seconds = allowed;
        until = steady_now() + allowed;
    }
    bool stopped() const { return patience.stop || patience.closed; }
    bool over() const { return stopped() || steady_now() > until; }
    AVIOInterruptCB callback() {
        return {[](void* watch) { return static_cast<int>(static_cast<Watch*>(watch)->over()); }, this};
    }
};

struct Options {
    AVDictionary* list = nullptr;
    ~Options() { av_dict_free(&list); }
    void set(const char* key, const char* value) { av_dict_set(&list, key, value, 0); }
};

Error cannot_open(const std::string& address, int code, const Watch& watch) {
    const std::string shown = shown_address(address);
    if (watch.stopped()) return Error{shown + ": stopped"};
    if (code == AVERROR_EXIT) return Error{fmt::format("{}: no answer within {:.0f} s: is the camera on, and the address right?", shown, watch.seconds)};
    if (code == AVERROR_HTTP_UNAUTHORIZED || code == AVERROR_HTTP_FORBIDDEN) {
        return Error{fmt::format("{}: the camera wants another user and password: write them before its name, //user:password@...", shown)};
    }
    if (code == AVERROR_HTTP_NOT_FOUND) return Error{fmt::format("{}: the camera has no stream of that name: look its path up in the manual", shown)};
    return Error{fmt::format("{}: no stream comes from there ({}): check the address, user and password in a player", shown, text_of(code))};
}

Error cannot_read(int code, const Watch& watch) {
    if (watch.stopped()) return Error{"stopped"};
    if (code == AVERROR_EXIT) return Error{fmt::format("no picture for {:.0f} s: is the camera still there?", watch.seconds)};
    if (code == AVERROR_EOF) return Error{"the camera ended its stream"};
    return Error{fmt::format("the stream broke off ({})", text_of(code))};
}

/// Does it hold a picture that needs none before it? Other kinds than H.264 and H.265 are taken to.
bool has_key_picture(const std::vector<std::uint8_t>& bytes, AVCodecID kind) {
    if (kind != AV_CODEC_ID_H264 && kind != AV_CODEC_ID_HEVC) return true;
    for (std::size_t i = 0; i + 3 < bytes.size(); ++i) {
        if (bytes[i] != 0 || bytes[i + 1] != 0 || bytes[i + 2] != 1) continue;
        const int unit = kind == AV_CODEC_ID_H264 ? bytes[i + 3] & 0x1f : (bytes[i + 3] >> 1) & 0x3f;
        if (kind == AV_CODEC_ID_H264 ? unit == 5 : unit >= 16 && unit <= 21) return true;
    }
    return false;
}

/// What libav says on its own goes nowhere: all that matters comes back as errors.
void keep_quiet() { av_log_set_level(AV_LOG_QUIET); }

}  // namespace

struct PacketStream::Impl {
    explicit Impl(const Patience& patience) : watch(patience) {}
    ~Impl() {
        av_packet_free(&packet);
        avformat_close_input(&format);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    const AVStream& stream() const { return *format->streams[video]; }

    Watch watch;
    AVFormatContext* format = nullptr;
    AVPacket* packet = av_packet_alloc();
    int video = -1;
    bool in_pieces = false;
    std::optional<StreamPacket> begun;  // a picture of which some pieces have come
    std::optional<StreamPacket> whole;
};

PacketStream::PacketStream(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PacketStream::~PacketStream() = default;

Result<std::unique_ptr<PacketStream>> PacketStream::open(const std::string& address, const Patience& patience) {
    keep_quiet();
    auto impl = std::make_unique<Impl>(patience);
    impl->format = avformat_alloc_context();
    impl->format->interrupt_callback = impl->watch.callback();
    impl->format->flags |= AVFMT_FLAG_NOBUFFER;
    // What libav would join gets the wall clock of the picture behind it.
    if (address.starts_with("rtsp")) impl->format->flags |= AVFMT_FLAG_NOPARSE | AVFMT_FLAG_NOFILLIN;
    Options options;
    options.set("rtsp_flags", "prefer_tcp");
    options.set("max_delay", microseconds_until_reordered);
    options.set("allowed_media_types", "video");
    if (const int code = avformat_open_input(&impl->format, address.c_str(), nullptr, &options.list); code < 0) {
        return cannot_open(address, code, impl->watch);
    }
    // An RTSP server describes its streams before they start; of others the first pictures have to be looked at.
    impl->in_pieces = std::strcmp(impl->format->iformat->name, "rtsp") == 0;
    if (!impl->in_pieces) {
        impl->format->max_analyze_duration = AV_TIME_BASE / 2;
        if (const int code = avformat_find_stream_info(impl->format, nullptr); code < 0) return cannot_open(address, code, impl->watch);
    }
    impl->video = av_find_best_stream(impl->format, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
    if (impl->video < 0) return Error{fmt::format("{}: there is no video in this stream", shown_address(address))};
    return std::unique_ptr<PacketStream>(new PacketStream(std::move(impl)));
}

/// Pieces with the same time are one picture.
Result<StreamPacket> PacketStream::read() {
    if (!impl_->in_pieces || is_jpeg()) return read_piece();
    while (true) {
        auto piece = read_piece();
        if (!piece) return piece.error();
        std::optional<StreamPacket>& begun = impl_->begun;
        if (begun && begun->media == piece->media && begun->bytes.size() < largest_picture) {
            begun->bytes.insert(begun->bytes.end(), piece->bytes.begin(), piece->bytes.end());
            continue;
        }
        std::swap(begun, impl_->whole);
        begun = std::move(*piece);
        if (!impl_->whole) continue;
        impl_->whole->key = has_key_picture(impl_->whole->bytes, impl_->stream().codecpar->codec_id);
        return std::move(*std::exchange(impl_->whole, std::nullopt));
    }
}

Result<StreamPacket> PacketStream::read_piece() {
    AVPacket* packet = impl_->packet;
    impl_->watch.start(impl_->watch.patience.to_read);
    do {
        av_packet_unref(packet);
        const int code = impl_->watch.over() ? AVERROR_EXIT : av_read_frame(impl_->format, packet);
        if (code < 0) return cannot_read(code, impl_->watch);
    } while (packet->stream_index != impl_->video || packet->size <= 0);
    StreamPacket read;
    read.steady = steady_now();
    read.system = system_now();
    read.bytes.assign(packet->data, packet->data + packet->size);
    read.key = (packet->flags & AV_PKT_FLAG_KEY) != 0;
    const std::int64_t stamp = packet->pts != AV_NOPTS_VALUE ? packet->pts : packet->dts;
    if (stamp != AV_NOPTS_VALUE) read.media = static_cast<double>(stamp) * av_q2d(impl_->stream().time_base);
    std::size_t size = 0;
    if (const std::uint8_t* data = av_packet_get_side_data(packet, AV_PKT_DATA_PRFT, &size); data && size >= sizeof(AVProducerReferenceTime)) {
        AVProducerReferenceTime reference;
        std::memcpy(&reference, data, sizeof reference);
        read.wall = reference.wallclock * 1000;
    }
    return read;
}

bool PacketStream::is_jpeg() const { return impl_->stream().codecpar->codec_id == AV_CODEC_ID_MJPEG; }

struct PictureDecoder::Impl {
    Impl() = default;
    ~Impl() {
        av_frame_free(&frame);
        av_frame_free(&next);
        av_packet_free(&packet);
        avcodec_free_context(&codec);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    AVCodecContext* codec = nullptr;
    AVFrame* frame = av_frame_alloc();
    AVFrame* next = av_frame_alloc();
    AVPacket* packet = av_packet_alloc();
};

PictureDecoder::PictureDecoder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PictureDecoder::~PictureDecoder() = default;

Result<std::unique_ptr<PictureDecoder>> PacketStream::decoder() const {
    const AVCodecParameters* parameters = impl_->stream().codecpar;
    const AVCodec* kind = avcodec_find_decoder(parameters->codec_id);
    if (kind == nullptr) return Error{fmt::format("video of the kind {} is not read: set the camera to H.264", avcodec_get_name(parameters->codec_id))};
    auto decoder = std::make_unique<PictureDecoder::Impl>();
    decoder->codec = avcodec_alloc_context3(kind);
    avcodec_parameters_to_context(decoder->codec, parameters);
    decoder->codec->flags |= AV_CODEC_FLAG_LOW_DELAY;
    decoder->codec->thread_count = 1;  // more would give each picture later
    if (const int code = avcodec_open2(decoder->codec, kind, nullptr); code < 0) {
        return Error{fmt::format("video of the kind {} cannot be decoded ({})", kind->name, text_of(code))};
    }
    return std::make_unique<PictureDecoder>(std::move(decoder));
}

Result<void> PictureDecoder::feed(const StreamPacket& packet, std::int64_t number) {
    AVPacket* coded = impl_->packet;
    av_packet_unref(coded);
    if (const int code = av_new_packet(coded, static_cast<int>(packet.bytes.size())); code < 0) return Error{text_of(code)};
    std::memcpy(coded->data, packet.bytes.data(), packet.bytes.size());
    coded->pts = coded->dts = number;
    if (packet.key) coded->flags |= AV_PKT_FLAG_KEY;
    if (const int code = avcodec_send_packet(impl_->codec, coded); code < 0) return Error{fmt::format("a picture is damaged ({})", text_of(code))};
    return {};
}

std::optional<std::int64_t> PictureDecoder::take() {
    if (avcodec_receive_frame(impl_->codec, impl_->next) < 0) return std::nullopt;
    std::swap(impl_->frame, impl_->next);
    return impl_->frame->pts;
}

Result<YuvView> PictureDecoder::picture() const {
    const AVFrame& frame = *impl_->frame;
    const auto format = static_cast<AVPixelFormat>(frame.format);
    const AVPixFmtDescriptor* kind = av_pix_fmt_desc_get(format);
    const bool planar = kind && (kind->flags & (AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_BITSTREAM | AV_PIX_FMT_FLAG_HWACCEL)) == 0;
    if (!planar || kind->comp[0].depth != 8)
        return Error{fmt::format("pictures of the kind {} are not read: set the camera to H.264, 8 bit", kind ? kind->name : "?")};
    YuvView view;
    view.width = frame.width;
    view.height = frame.height;
    view.y = frame.data[kind->comp[0].plane] + kind->comp[0].offset;
    view.y_stride = frame.linesize[kind->comp[0].plane];
    view.y_step = kind->comp[0].step;
    view.full_range = frame.color_range == AVCOL_RANGE_JPEG || format == AV_PIX_FMT_YUVJ420P || format == AV_PIX_FMT_YUVJ422P || format == AV_PIX_FMT_YUVJ444P;
    if (kind->nb_components < 3) return view;
    view.u = frame.data[kind->comp[1].plane] + kind->comp[1].offset;
    view.v = frame.data[kind->comp[2].plane] + kind->comp[2].offset;
    view.colour_stride = frame.linesize[kind->comp[1].plane];
    view.colour_step = kind->comp[1].step;
    view.shift_x = kind->log2_chroma_w;
    view.shift_y = kind->log2_chroma_h;
    return view;
}

struct ByteStream::Impl {
    explicit Impl(const Patience& patience) : watch(patience) {}
    ~Impl() { avio_closep(&io); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    Watch watch;
    AVIOContext* io = nullptr;
    std::string content_type;
    std::array<std::uint8_t, 65536> buffer;
};

ByteStream::ByteStream(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ByteStream::~ByteStream() = default;

Result<std::unique_ptr<ByteStream>> ByteStream::open(const std::string& address, const Patience& patience) {
    keep_quiet();
    auto impl = std::make_unique<Impl>(patience);
    const AVIOInterruptCB callback = impl->watch.callback();
    if (const int code = avio_open2(&impl->io, address.c_str(), AVIO_FLAG_READ, &callback, nullptr); code < 0) return cannot_open(address, code, impl->watch);
    std::uint8_t* type = nullptr;
    if (av_opt_get(impl->io, "mime_type", AV_OPT_SEARCH_CHILDREN, &type) >= 0 && type != nullptr) impl->content_type = reinterpret_cast<const char*>(type);
    av_free(type);
    return std::unique_ptr<ByteStream>(new ByteStream(std::move(impl)));
}

const std::string& ByteStream::content_type() const { return impl_->content_type; }

Result<std::span<const std::uint8_t>> ByteStream::read() {
    impl_->watch.start(impl_->watch.patience.to_read);
    const int count = avio_read_partial(impl_->io, impl_->buffer.data(), static_cast<int>(impl_->buffer.size()));
    if (count <= 0) return cannot_read(count == 0 ? AVERROR_EOF : count, impl_->watch);
    return std::span<const std::uint8_t>(impl_->buffer.data(), static_cast<std::size_t>(count));
}

}  // namespace roomfix
