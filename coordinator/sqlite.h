// SQLite with errors as exceptions. Not thread-safe: one owner.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace lodestar {

class Database {
 public:
  // Opens or creates; rollback journal, synchronous=EXTRA (the journal's own folder is synchronised too).
  explicit Database(const std::filesystem::path& file);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  void Execute(const std::string& sql);
  // Commits at the end, rolls back where `body` throws.
  void Transaction(const std::function<void()>& body);
  int64_t LastRowId() const;
  sqlite3* handle() const { return handle_; }

 private:
  sqlite3* handle_ = nullptr;
};

class Statement {
 public:
  Statement(Database& database, std::string_view sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;
  Statement& Bind(int64_t value);
  Statement& Bind(std::string_view value);  // text
  Statement& BindBlob(std::string_view value);
  // False when there is no further row.
  bool Step();
  void Run() {
    while (Step()) {
    }
  }
  int64_t Integer(int column) const;
  std::string Text(int column) const;  // text or blob

 private:
  Database& database_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

}  // namespace lodestar
