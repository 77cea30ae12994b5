#include "recordings/logs/message_log.h"

#ifdef FUSE_FLOW_WITH_SQLITE
#include <sqlite3.h>
#endif

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <system_error>

namespace fuse_flow::io {

#ifndef FUSE_FLOW_WITH_SQLITE

std::unique_ptr<MessageLog> openSqliteBag(const std::string& path) {
  throw InputError(path +
                   ": cannot be read, since FUSE-Flow was built without SQLite; install libsqlite3-dev, and build it "
                   "again");
}

#else

namespace {

/** \brief A query, whose rows are read one after the other. */
class Query {
 public:
  Query(sqlite3* database, const std::string& path, const char* text) : database_(database), path_(path) {
    if (sqlite3_prepare_v2(database, text, -1, &statement_, nullptr) != SQLITE_OK) fail();
  }
  ~Query() { sqlite3_finalize(statement_); }
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  /** \brief False behind the last row. */
  bool step() {
    const int result = sqlite3_step(statement_);
    if (result != SQLITE_ROW && result != SQLITE_DONE) fail();
    return result == SQLITE_ROW;
  }
  void restart(std::int64_t parameter) {
    sqlite3_reset(statement_);
    sqlite3_bind_int64(statement_, 1, parameter);
  }
  std::int64_t number(int column) { return sqlite3_column_int64(statement_, column); }
  std::string bytes(int column) {
    const void* data = sqlite3_column_blob(statement_, column);  // before its size, says SQLite
    const int size = sqlite3_column_bytes(statement_, column);
    return data ? std::string(static_cast<const char*>(data), static_cast<std::size_t>(size)) : std::string();
  }

 private:
  [[noreturn]] void fail() {
    throw InputError(path_ + ": is damaged, or no bag of ROS 2: " + sqlite3_errmsg(database_));
  }

  sqlite3* database_;
  const std::string& path_;
  sqlite3_stmt* statement_{nullptr};
};

class SqliteLog : public MessageLog {
 public:
  explicit SqliteLog(const std::string& path) {
    path_ = path;
    sqlite3* database = nullptr;
    const int result = sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READONLY, nullptr);
    database_.reset(database);
    if (result != SQLITE_OK) throw InputError(path + ": cannot be opened: " + sqlite3_errstr(result));
    // A row says how long it is, and SQLite takes that memory before it reads: no row is longer than the file. SQLite 3.40 does not look at this limit
    // here; what it takes then is given back untouched, as there is nothing to read.
    std::error_code unknown;
    const std::uintmax_t size = std::filesystem::file_size(path, unknown);
    constexpr std::uintmax_t most = std::numeric_limits<int>::max();
    if (!unknown) sqlite3_limit(database_.get(), SQLITE_LIMIT_LENGTH, static_cast<int>(std::min(size, most)));
    readTopics();
    readTimes();
    data_ = std::make_unique<Query>(database, path_, "SELECT data FROM messages WHERE id = ?");
    start_ = std::make_unique<Query>(database, path_, "SELECT substr(data, 1, 4096) FROM messages WHERE id = ?");
  }

  void read(std::size_t topic, std::size_t message, std::string& bytes) override {
    fetch(*data_, topic, message, bytes);
  }
  void readStart(std::size_t topic, std::size_t message, std::size_t count, std::string& bytes) override {
    fetch(count <= 4096 ? *start_ : *data_, topic, message, bytes);
  }

 private:
  void readTopics() {
    Query query(database_.get(), path_, "SELECT id, name, type, serialization_format FROM topics ORDER BY id");
    while (query.step()) {
      Topic topic;
      topic.name = query.bytes(1);
      topic.type = query.bytes(2);
      topic.wire = Wire::Cdr;
      if (const std::size_t message = topic.type.find("/msg/"); message != std::string::npos)
        topic.type.erase(message, 4);
      if (const std::string format = query.bytes(3); format != "cdr") topic.type += " in " + format;
      number_of_[query.number(0)] = topics_.size();
      topics_.push_back(std::move(topic));
      rows_.emplace_back();
    }
  }

  void readTimes() {
    Query query(database_.get(), path_, "SELECT id, topic_id, timestamp FROM messages ORDER BY timestamp, id");
    while (query.step()) {
      const auto found = number_of_.find(query.number(1));
      if (found == number_of_.end()) continue;
      rows_[found->second].push_back(query.number(0));
      topics_[found->second].times.push_back(std::clamp<Nanoseconds>(query.number(2), 0, kLatestTime));
    }
  }

  void fetch(Query& query, std::size_t topic, std::size_t message, std::string& bytes) {
    query.restart(rows_.at(topic).at(message));
    if (!query.step()) throw InputError(path_ + ": a message is no longer there");
    bytes = query.bytes(0);
  }

  struct Close {
    void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
  };
  std::unique_ptr<sqlite3, Close> database_;
  std::map<std::int64_t, std::size_t> number_of_;  // of a topic, by its id
  std::vector<std::vector<std::int64_t> > rows_;   // of each topic's messages
  std::unique_ptr<Query> data_, start_;
};

}  // namespace

std::unique_ptr<MessageLog> openSqliteBag(const std::string& path) { return std::make_unique<SqliteLog>(path); }

#endif

}  // namespace fuse_flow::io
