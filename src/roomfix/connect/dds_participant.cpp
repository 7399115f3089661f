#include "roomfix/connect/dds_participant.hpp"

#include <fmt/format.h>

#include <cstdlib>

#include "roomfix/base/number.hpp"

#ifdef ROOMFIX_WITH_ROS2
#include <algorithm>
#include <chrono>
#include <fastdds/dds/core/condition/WaitSet.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/log/StdoutErrConsumer.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <map>
#include <mutex>
#include <utility>

#include "roomfix/connect/dds_settings.hpp"
#include "roomfix/connect/ros_graph.hpp"
#endif

namespace roomfix {

#ifdef ROOMFIX_WITH_ROS2

namespace {

using eprosima::fastrtps::types::ReturnCode_t;

ros::Guid number_of(const rtps::GUID_t& guid) {
    ros::Guid number;
    const auto end = std::copy(std::begin(guid.guidPrefix.value), std::end(guid.guidPrefix.value), number.begin());
    std::copy(std::begin(guid.entityId.value), std::end(guid.entityId.value), end);
    return number;
}

/// Which types others publish on which topics.
class TypesOfOthers : public dds::DomainParticipantListener {
public:
    void on_publisher_discovery(dds::DomainParticipant*, rtps::WriterDiscoveryInfo&& found) override {
        const std::lock_guard lock(mutex_);
        std::vector<std::string>& types = types_[found.info.topicName().to_string()];
        const std::string type = found.info.typeName().to_string();
        if (found.status == rtps::WriterDiscoveryInfo::DISCOVERED_WRITER) types.push_back(type);
        const auto gone = found.status == rtps::WriterDiscoveryInfo::REMOVED_WRITER ? std::find(types.begin(), types.end(), type) : types.end();
        if (gone != types.end()) types.erase(gone);
        if (types.empty()) types_.erase(found.info.topicName().to_string());
    }
    std::string other_than(const std::string& dds_topic, const std::string& type) const {
        const std::lock_guard lock(mutex_);
        const auto known = types_.find(dds_topic);
        if (known == types_.end()) return "";
        const auto other = std::find_if(known->second.begin(), known->second.end(), [&](const std::string& t) { return t != type; });
        return other == known->second.end() ? "" : *other;
    }

private:
    mutable std::mutex mutex_;
    std::map<std::string, std::vector<std::string>> types_;
};

std::vector<Bytes> taken_from(dds::DataReader& reader) {
    std::vector<Bytes> messages;
    Bytes message;
    dds::SampleInfo info;
    while (reader.take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK) {
        if (info.valid_data) messages.push_back(std::move(message));
        message.clear();
    }
    return messages;
}

}  // namespace

struct DdsParticipant::Impl {
    explicit Impl(int number) : domain(number) {}
    ~Impl() {
        if (participant == nullptr) return;
        participant->set_listener(nullptr);
        for (const auto& [name, reader] : readers) waiting.detach_condition(reader->get_statuscondition());
        participant->delete_contained_entities();
        dds::DomainParticipantFactory::get_instance()->delete_participant(participant);
    }
    /// On DDS's side; null where it cannot be had.
    dds::Topic* topic(const std::string& dds_topic, const std::string& type) {
        dds::TypeSupport support(new ReadyMessage(type));
        if (support.register_type(participant) != ReturnCode_t::RETCODE_OK) return nullptr;
        return participant->create_topic(dds_topic, support.get_type_name(), dds::TOPIC_QOS_DEFAULT);
    }
    dds::DataReader* reader_of(const std::string& topic) const {
        const std::lock_guard lock(mutex);
        const auto found = readers.find(topic);
        return found == readers.end() ? nullptr : found->second;
    }
    ros::ParticipantEntitiesInfo entities() const {
        ros::ParticipantEntitiesInfo all;
        all.participant = number_of(participant->guid());
        all.node_name = node;
        const std::lock_guard lock(mutex);
        for (const auto& [name, writer] : writers) all.writers.push_back(number_of(writer->guid()));
        for (const auto& [name, reader] : readers) all.readers.push_back(number_of(reader->guid()));
        return all;
    }

    int domain;
    std::string node;
    TypesOfOthers types;
    dds::DomainParticipant* participant = nullptr;
    dds::Publisher* publisher = nullptr;
    dds::Subscriber* subscriber = nullptr;
    dds::WaitSet waiting;  // for wanted topics
    dds::Topic* graph_topic = nullptr;
    dds::DataReader* graph_reader = nullptr;
    dds::DataWriter* graph_writer = nullptr;  // null until its layout is known
    std::optional<ros::GraphLayout> layout;
    Bytes told_graph;
    mutable std::mutex mutex;  // guards:
    std::map<std::string, dds::DataWriter*> writers;
    std::map<std::string, dds::DataReader*> readers;
};

Result<std::unique_ptr<DdsParticipant>> DdsParticipant::join(int domain, const std::string& node) {
    // What the library complains about belongs on stderr, not among the results.
    dds::Log::ClearConsumers();
    auto complaints = std::make_unique<dds::StdoutErrConsumer>();
    complaints->stderr_threshold(dds::Log::Kind::Info);
    dds::Log::RegisterConsumer(std::move(complaints));

    auto impl = std::make_unique<Impl>(domain);
    impl->node = node;
    impl->participant = dds::DomainParticipantFactory::get_instance()->create_participant(static_cast<std::uint32_t>(domain), participant_qos(), &impl->types,
                                                                                          dds::StatusMask::none());
    if (impl->participant != nullptr) impl->publisher = impl->participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    if (impl->participant != nullptr) impl->subscriber = impl->participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
    if (impl->publisher == nullptr || impl->subscriber == nullptr) {
        constexpr int first_port = 7400, ports_of_a_domain = 250;
        return Error{fmt::format("ROS 2: domain {} cannot be joined: is there a network, and are its UDP ports free ({} and the next ones)?", domain,
                                 first_port + ports_of_a_domain * domain)};
    }
    impl->graph_topic = impl->topic(ros::graph_topic, ros::graph_type);
    constexpr int nodes_kept = 100;
    if (impl->graph_topic != nullptr) impl->graph_reader = impl->subscriber->create_datareader(impl->graph_topic, kept_for_others(reader_qos(nodes_kept)));
    return std::unique_ptr<DdsParticipant>(new DdsParticipant(std::move(impl)));
}

Result<void> DdsParticipant::offer(const std::string& topic, RosType type, int depth) {
    const std::lock_guard lock(impl_->mutex);
    if (impl_->writers.contains(topic)) return {};
    dds::Topic* offered = impl_->topic(dds_topic_of(topic), dds_name_of(type));
    dds::DataWriter* writer = offered == nullptr ? nullptr : impl_->publisher->create_datawriter(offered, writer_qos(depth));
    if (writer == nullptr) return Error{fmt::format("ROS 2: the topic {} cannot be offered in domain {}", topic, impl_->domain)};
    impl_->writers[topic] = writer;
    return {};
}

void DdsParticipant::withdraw(const std::string& topic) {
    const std::lock_guard lock(impl_->mutex);
    const auto found = impl_->writers.find(topic);
    if (found == impl_->writers.end()) return;
    dds::Topic* offered = found->second->get_topic();
    impl_->publisher->delete_datawriter(found->second);
    impl_->participant->delete_topic(offered);
    impl_->writers.erase(found);
}

Result<void> DdsParticipant::publish(const std::string& topic, const Bytes& message) {
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

void DdsParticipant::wait_until_received(double longest) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(longest);
    const std::lock_guard lock(impl_->mutex);
    for (const auto& [topic, writer] : impl_->writers) {
        const double left = std::chrono::duration<double>(end - std::chrono::steady_clock::now()).count();
        if (left > 0) writer->wait_for_acknowledgments(eprosima::fastrtps::Duration_t(static_cast<long double>(left)));
    }
}

Result<void> DdsParticipant::want(const std::string& topic, RosType type, int depth) {
    const std::lock_guard lock(impl_->mutex);
    if (impl_->readers.contains(topic)) return {};
    dds::Topic* wanted = impl_->topic(dds_topic_of(topic), dds_name_of(type));
    dds::DataReader* reader = wanted == nullptr ? nullptr : impl_->subscriber->create_datareader(wanted, reader_qos(depth));
    if (reader == nullptr) return Error{fmt::format("ROS 2: the topic {} cannot be listened to in domain {}", topic, impl_->domain)};
    reader->get_statuscondition().set_enabled_statuses(dds::StatusMask::data_available());
    impl_->waiting.attach_condition(reader->get_statuscondition());
    impl_->readers[topic] = reader;
    return {};
}

void DdsParticipant::wait(double longest) {
    dds::ConditionSeq come;
    impl_->waiting.wait(come, eprosima::fastrtps::Duration_t(static_cast<long double>(longest)));
}

std::vector<Bytes> DdsParticipant::take(const std::string& topic) {
    dds::DataReader* reader = impl_->reader_of(topic);
    return reader == nullptr ? std::vector<Bytes>() : taken_from(*reader);
}

int DdsParticipant::publishers(const std::string& topic) const {
    dds::DataReader* reader = impl_->reader_of(topic);
    dds::SubscriptionMatchedStatus matched;
    if (reader == nullptr || reader->get_subscription_matched_status(matched) != ReturnCode_t::RETCODE_OK) return 0;
    return matched.current_count;
}

std::string DdsParticipant::other_type(const std::string& topic) const {
    const dds::DataReader* reader = impl_->reader_of(topic);
    return reader == nullptr ? "" : impl_->types.other_than(dds_topic_of(topic), reader->get_topicdescription()->get_type_name());
}

void DdsParticipant::tell_graph() {
    if (impl_->graph_reader == nullptr) return;
    for (const Bytes& word : taken_from(*impl_->graph_reader)) {
        if (!impl_->layout) impl_->layout = ros::layout_of_graph(word);
    }
    if (!impl_->layout) return;
    if (impl_->graph_writer == nullptr) impl_->graph_writer = impl_->publisher->create_datawriter(impl_->graph_topic, kept_for_others(writer_qos(1)));
    Bytes graph = ros::encode(impl_->entities(), *impl_->layout);
    if (graph == impl_->told_graph || impl_->graph_writer == nullptr) return;
    if (impl_->graph_writer->write(&graph)) impl_->told_graph = std::move(graph);
}

#else

struct DdsParticipant::Impl {};

Result<std::unique_ptr<DdsParticipant>> DdsParticipant::join(int, const std::string&) {
    return Error{"ROS 2: this roomfix was built without DDS: install libfastrtps-dev and build it again, or take 'ros2' out of the site file"};
}
Result<void> DdsParticipant::offer(const std::string&, RosType, int) { return {}; }
void DdsParticipant::withdraw(const std::string&) {}
Result<void> DdsParticipant::publish(const std::string&, const Bytes&) { return {}; }
void DdsParticipant::wait_until_received(double) {}
Result<void> DdsParticipant::want(const std::string&, RosType, int) { return {}; }
void DdsParticipant::wait(double) {}
std::vector<Bytes> DdsParticipant::take(const std::string&) { return {}; }
int DdsParticipant::publishers(const std::string&) const { return 0; }
std::string DdsParticipant::other_type(const std::string&) const { return ""; }
void DdsParticipant::tell_graph() {}

#endif

Result<int> domain_of_environment() {
    const char* text = std::getenv("ROS_DOMAIN_ID");
    if (text == nullptr || *text == '\0') return 0;
    constexpr int most = 232;
    const auto number = parse_integer(text);
    if (number && *number >= 0 && *number <= most) return static_cast<int>(*number);
    return Error{fmt::format("ROS_DOMAIN_ID is '{}' in the environment: a domain is a number from 0 to {}", text, most)};
}

DdsParticipant::DdsParticipant(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DdsParticipant::~DdsParticipant() = default;

}  // namespace roomfix
