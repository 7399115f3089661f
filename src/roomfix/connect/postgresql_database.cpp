#include <fmt/format.h>

#include <utility>

#include "roomfix/connect/sql_database.hpp"

#ifdef ROOMFIX_WITH_POSTGRESQL
#include <poll.h>
#include <sys/socket.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <pqxx/pqxx>
#include <thread>
#endif

namespace roomfix {

#ifdef ROOMFIX_WITH_POSTGRESQL
namespace {

/// An address with a setting added, unless it says something of it already.
std::string with_setting(const std::string& address, const std::string& name, const std::string& value) {
    if (address.find(name + "=") != std::string::npos) return address;
    const std::size_t at = address.rfind('@');  // a password may hold a question mark
    const bool has_settings = address.find('?', at == std::string::npos ? 0 : at) != std::string::npos;
    return fmt::format("{}{}{}={}", address, has_settings ? '&' : '?', name, value);
}

/// An address in its parts, as far as messages need them.
struct AddressParts {
    std::string password;
    std::string shown;  // without user, password and settings
};

AddressParts parts_of(const std::string& address) {
    const std::size_t begin = address.find("://") + 3;
    const std::string rest = address.substr(begin);
    const std::size_t at = rest.rfind('@');  // a password may hold any character
    const std::string place = at == std::string::npos ? rest : rest.substr(at + 1);
    const std::size_t colon = rest.find(':');
    const bool has_password = at != std::string::npos && colon < at;
    return {has_password ? rest.substr(colon + 1, at - colon - 1) : "", "postgresql://" + place.substr(0, place.find('?'))};
}

constexpr std::chrono::seconds longest_answer(15);

/// Ends a connection whose server takes a question and never answers: no setting of PostgreSQL's notices that.
class Deadline {
public:
    /// `missed` is set where it is.
    Deadline(int socket, std::atomic<bool>& missed) : missed_(missed), thread_([this, socket] { watch(socket); }) {}
    ~Deadline() {
        {
            const std::lock_guard lock(mutex_);
            kept_ = true;
        }
        changed_.notify_all();
        thread_.join();
    }
    Deadline(const Deadline&) = delete;
    Deadline& operator=(const Deadline&) = delete;

private:
    void watch(int socket) {
        std::unique_lock lock(mutex_);
        if (changed_.wait_for(lock, longest_answer, [this] { return kept_; })) return;
        missed_ = true;
        ::shutdown(socket, SHUT_RDWR);
    }

    std::atomic<bool>& missed_;
    std::mutex mutex_;  // guards:
    bool kept_ = false;
    std::condition_variable changed_;
    std::thread thread_;
};

/// Has the other end closed it? A question over such a connection fails, and libpqxx forgets the memory of that failure.
bool has_ended(int socket) {
    pollfd asked{socket, POLLRDHUP, 0};
    return ::poll(&asked, 1, 0) > 0 && (asked.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

class PostgresqlDatabase final : public SqlDatabase {
public:
    PostgresqlDatabase(const std::string& address, std::vector<std::string> setup) : parts_(parts_of(address)), setup_(std::move(setup)) {
        // A server that is gone without a word is noticed after some seconds.
        address_ = address;
        for (const auto& [name, value] : {std::pair{"connect_timeout", "3"},
                                          {"tcp_user_timeout", "5000"},
                                          {"keepalives_idle", "5"},
                                          {"keepalives_interval", "2"},
                                          {"keepalives_count", "2"},
                                          {"client_encoding", "UTF8"}}) {
            address_ = with_setting(address_, name, value);
        }
    }

    Result<void> run(const std::vector<std::string>& statements) override {
        return attempt<void>([&](pqxx::work& work) {
            for (const std::string& statement : statements) work.exec(statement);
            work.commit();
            return Result<void>();
        });
    }

    Result<std::vector<SqlRow>> rows(const std::string& select) override {
        return attempt<std::vector<SqlRow>>([&](pqxx::work& work) {
            std::vector<SqlRow> rows;
            for (const pqxx::row& found : work.exec(select)) {
                SqlRow& row = rows.emplace_back();
                for (const pqxx::field& field : found) row.push_back(field.is_null() ? std::nullopt : std::optional<std::string>(field.c_str()));
            }
            return Result<std::vector<SqlRow>>(std::move(rows));
        });
    }

private:
    template <class T, class Work>
    Result<T> attempt(const Work& work) {
        std::atomic<bool> missed{false};
        try {
            if (connection_ && has_ended(connection_->sock())) connection_.reset();
            if (!connection_) connect(missed);
            const Deadline deadline(connection_->sock(), missed);
            pqxx::work transaction(*connection_);
            return work(transaction);
        } catch (const std::exception& problem) {
            connection_.reset();  // whatever it was, a new connection does not suffer from it
            if (missed) return Error{fmt::format("history {}: the server did not answer within {} s", parts_.shown, longest_answer.count())};
            return Error{fmt::format("history {}: {}; is the server running, and do user and password fit (PGPASSWORD, ~/.pgpass)?", parts_.shown,
                                     shown(problem.what()))};
        }
    }

    void connect(std::atomic<bool>& missed) {
        auto connection = std::make_unique<pqxx::connection>(address_);
        const Deadline deadline(connection->sock(), missed);
        pqxx::work work(*connection);
        work.exec("SET client_min_messages = warning");  // that a table exists already is no news
        for (const std::string& statement : setup_) work.exec(statement);
        work.exec("SET statement_timeout = 10000");  // ms
        work.commit();
        connection_ = std::move(connection);
    }

    /// A message on one line, without the password that it may quote.
    std::string shown(std::string text) const {
        for (std::size_t at = 0; !parts_.password.empty() && (at = text.find(parts_.password, at)) != std::string::npos; at += 3) {
            text.replace(at, parts_.password.size(), "***");
        }
        while (!text.empty() && text.back() == '\n') text.pop_back();
        for (char& c : text) {
            if (c == '\n' || c == '\t') c = ' ';
        }
        return text;
    }

    std::string address_;
    AddressParts parts_;
    std::vector<std::string> setup_;
    std::unique_ptr<pqxx::connection> connection_;
};

}  // namespace

Result<std::unique_ptr<SqlDatabase>> postgresql_database(const std::string& address, std::vector<std::string> setup) {
    return std::unique_ptr<SqlDatabase>(std::make_unique<PostgresqlDatabase>(address, std::move(setup)));
}

#else

Result<std::unique_ptr<SqlDatabase>> postgresql_database(const std::string&, std::vector<std::string>) {
    return Error{"outputs.history: this roomfix was built without PostgreSQL: install libpqxx-dev and build it anew, or give an SQLite file as 'database'"};
}

#endif

}  // namespace roomfix
