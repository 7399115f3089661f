#include "roomfix/connect/dds_publisher.hpp"

#include <fmt/format.h>

#ifdef ROOMFIX_WITH_ROS2
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/log/StdoutErrConsumer.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <map>
#include <mutex>
#include <utility>
#endif

namespace roomfix {

#ifdef ROOMFIX_WITH_ROS2

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

namespace {

/// A type of which DDS knows the name alone: its messages come as bytes.
class ReadyMessage : public dds::TopicDataType {
public:
    explicit ReadyMessage(const std::string& name) {
        setName(name.c_str());
        m_typeSize = 1024;  // more is reserved for messages that need it
        m_isGetKeyDefined = false;
        auto_fill_type_object(false);
        auto_fill_type_information(false);
    }
    bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
        const Bytes& message = *static_cast<const Bytes*>(data);
        if (message.size() > payload->max_size) return false;
        std::memcpy(payload->data, message.data(), message.size());
        payload->length = static_cast<std::uint32_t>(message.size());
        payload->encapsulation = CDR_LE;
        return true;
    }
    std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
        const auto size = static_cast<std::uint32_t>(static_cast<const Bytes*>(data)->size());
        return [size] { return size; };
    }
    // Nothing is read:
    bool deserialize(rtps::SerializedPayload_t*, void*) override { return false; }
    void* createData() override { return new Bytes(); }
    void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
    bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

bool this_machine_only() {
    const char* value = std::getenv("ROS_LOCALHOST_ONLY");
    return value != nullptr && std::string(value) == "1";
}

/// What stands in the profile file of the user, if there is one (FASTRTPS_DEFAULT_PROFILES_FILE), but for what ROS says by its own variables.
dds::DomainParticipantQos participant_qos() {
    dds::DomainParticipantFactory* factory = dds::DomainParticipantFactory::get_instance();
    factory->load_profiles();
    dds::DomainParticipantQos qos = factory->get_default_participant_qos();
    qos.name("roomfix");
    const bool own_transports = !qos.transport().user_transports.empty();
    if (own_transports && !this_machine_only()) return qos;
    // UDP alone: shared memory fails silently between containers, and stays behind after a crash.
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    if (this_machine_only()) {
        udp->interfaceWhiteList.emplace_back("127.0.0.1");
        rtps::Locator_t here;
        rtps::IPLocator::setIPv4(here, 127, 0, 0, 1);
        qos.wire_protocol().builtin.initialPeersList.push_back(here);  // of interfaces without multicast
        rtps::IPLocator::setIPv4(here, 239, 255, 0, 1);
        qos.wire_protocol().builtin.initialPeersList.push_back(here);
    }
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports = {udp};
    return qos;
}

dds::DataWriterQos writer_qos(int depth) {
    dds::DataWriterQos qos;
    qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = depth;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.data_sharing().off();
    return qos;
}

}  // namespace

struct DdsPublisher::Impl {
    explicit Impl(int number) : domain(number) {}
    ~Impl() {
        if (participant == nullptr) return;
        participant->delete_contained_entities();
        dds::DomainParticipantFactory::get_instance()->delete_participant(participant);
    }

    int domain;
    dds::DomainParticipant* participant = nullptr;
    dds::Publisher* publisher = nullptr;
    std::mutex mutex;  // guards:
    std::map<std::string, dds::DataWriter*> writers;
};

Result<std::unique_ptr<DdsPublisher>> DdsPublisher::join(int domain) {
    // What the library complains about belongs on stderr, not among the results.
    dds::Log::ClearConsumers();
    auto complaints = std::make_unique<dds::StdoutErrConsumer>();
    complaints->stderr_threshold(dds::Log::Kind::Info);
    dds::Log::RegisterConsumer(std::move(complaints));

    auto impl = std::make_unique<Impl>(domain);
    impl->participant = dds::DomainParticipantFactory::get_instance()->create_participant(static_cast<std::uint32_t>(domain), participant_qos());
    if (impl->participant != nullptr) impl->publisher = impl->participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    if (impl->publisher == nullptr) {
        constexpr int first_port = 7400, ports_of_a_domain = 250;
        return Error{fmt::format("ROS 2: domain {} cannot be joined: is there a network, and are its UDP ports free ({} and the next ones)?", domain,
                                 first_port + ports_of_a_domain * domain)};
    }
    return std::unique_ptr<DdsPublisher>(new DdsPublisher(std::move(impl)));
}

Result<void> DdsPublisher::offer(const std::string& topic, RosType type, int depth) {
    const std::lock_guard lock(impl_->mutex);
    if (impl_->writers.contains(topic)) return {};
    dds::TypeSupport support(new ReadyMessage(dds_name_of(type)));
    dds::Topic* offered = nullptr;
    if (support.register_type(impl_->participant) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
        offered = impl_->participant->create_topic(dds_topic_of(topic), support.get_type_name(), dds::TOPIC_QOS_DEFAULT);
    }
    dds::DataWriter* writer = offered == nullptr ? nullptr : impl_->publisher->create_datawriter(offered, writer_qos(depth));
    if (writer == nullptr) return Error{fmt::format("ROS 2: the topic {} cannot be offered in domain {}", topic, impl_->domain)};
    impl_->writers[topic] = writer;
    return {};
}

void DdsPublisher::withdraw(const std::string& topic) {
    const std::lock_guard lock(impl_->mutex);
    const auto found = impl_->writers.find(topic);
    if (found == impl_->writers.end()) return;
    dds::Topic* offered = found->second->get_topic();
    impl_->publisher->delete_datawriter(found->second);
    impl_->participant->delete_topic(offered);
    impl_->writers.erase(found);
}

Result<void> DdsPublisher::publish(const std::string& topic, const Bytes& message) {
    dds::DataWriter* writer = nullptr;
    {
        const std::lock_guard lock(impl_->mutex);
        const auto found = impl_->writers.find(topic);
        if (found != impl_->writers.end()) writer = found->second;
    }
    Bytes copy = message;  // the library asks for something that it might change
    if (writer != nullptr && writer->write(&copy)) return {};
    return Error{fmt::format("ROS 2: a message on {} could not be sent and is lost: does who listens keep up?", topic)};
}

void DdsPublisher::wait_until_received(double longest) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(longest);
    const std::lock_guard lock(impl_->mutex);
    for (const auto& [topic, writer] : impl_->writers) {
        const double left = std::chrono::duration<double>(end - std::chrono::steady_clock::now()).count();
        if (left > 0) writer->wait_for_acknowledgments(eprosima::fastrtps::Duration_t(static_cast<long double>(left)));
    }
}

#else

struct DdsPublisher::Impl {};

Result<std::unique_ptr<DdsPublisher>> DdsPublisher::join(int) {
    return Error{"outputs.ros2: this roomfix was built without DDS: install libfastrtps-dev and build it again, or take 'ros2' out of the site file"};
}
Result<void> DdsPublisher::offer(const std::string&, RosType, int) { return {}; }
void DdsPublisher::withdraw(const std::string&) {}
Result<void> DdsPublisher::publish(const std::string&, const Bytes&) { return {}; }
void DdsPublisher::wait_until_received(double) {}

#endif

DdsPublisher::DdsPublisher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DdsPublisher::~DdsPublisher() = default;

}  // namespace roomfix
