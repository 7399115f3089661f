// How we take part in DDS: what is sent, over what, with which quality of service. The library's headers are heavy: only `dds_participant.cpp` includes this.
#pragma once

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include <cstdlib>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <memory>
#include <string>
#include <vector>

#include "roomfix/connect/little_endian.hpp"

namespace roomfix {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

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
    bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
        constexpr std::uint32_t longest = 1 << 20;  // bytes: nothing that is wanted is longer
        if (payload->length > longest) return false;
        static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
        return true;
    }
    void* createData() override { return new Bytes(); }
    void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
    bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

inline bool this_machine_only() {
    const char* value = std::getenv("ROS_LOCALHOST_ONLY");
    return value != nullptr && std::string(value) == "1";
}

/// What stands in the profile file of the user, if there is one (FASTRTPS_DEFAULT_PROFILES_FILE), but for what ROS says by its own variables.
inline dds::DomainParticipantQos participant_qos() {
    dds::DomainParticipantFactory* factory = dds::DomainParticipantFactory::get_instance();
    factory->load_profiles();
    dds::DomainParticipantQos qos = factory->get_default_participant_qos();
    qos.name("roomfix");
    const std::string enclave = "enclave=/;";  // ROS 2's participants say so
    qos.user_data().data_vec(std::vector<rtps::octet>(enclave.begin(), enclave.end()));
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

/// What a writer's and a reader's quality of service have in common: the last `depth` messages, for those who are there.
template <class Qos>
Qos last_messages(dds::ReliabilityQosPolicyKind reliability, int depth) {
    Qos qos;
    qos.reliability().kind = reliability;
    qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = depth;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.data_sharing().off();
    return qos;
}

/// As ROS 2 nodes have it by default.
inline dds::DataWriterQos writer_qos(int depth) { return last_messages<dds::DataWriterQos>(dds::RELIABLE_RELIABILITY_QOS, depth); }

/// Whatever is published, reliably or not.
inline dds::DataReaderQos reader_qos(int depth) { return last_messages<dds::DataReaderQos>(dds::BEST_EFFORT_RELIABILITY_QOS, depth); }

/// What is told of the nodes is for those who come later, too.
template <class Qos>
Qos kept_for_others(Qos qos) {
    qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
    return qos;
}

}  // namespace roomfix
