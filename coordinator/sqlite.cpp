#include "coordinator/sqlite.h"

#include <sqlite3.h>

#include "core/base/error.h"

namespace lodestar {
namespace {

[[noreturn]] void Fail(sqlite3* handle, const std::string& doing) {
  const int code = handle ? sqlite3_errcode(handle) : SQLITE_CANTOPEN;
  std::string text = "the job store failed while " + doing + ": " + (handle ? sqlite3_errmsg(handle) : "out of memory");
  if (code == SQLITE_FULL) text += " (free some space on its disk)";
  if (code == SQLITE_BUSY) text += " (another coordinator uses this store: stop it, or take another --store)";
  throw Error(code == SQLITE_CORRUPT || code == SQLITE_NOTADB ? ErrorKind::kCorrupt : ErrorKind::kIo, text);
}

}  // namespace

Database::Database(const std::filesystem::path& file) {
  if (sqlite3_open_v2(file.c_str(), &handle_, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX,
                      nullptr) != SQLITE_OK) {
    try {
      Fail(handle_, "opening " + file.string());
    } catch (...) {
      sqlite3_close(handle_);
      throw;
    }
  }
  sqlite3_busy_timeout(handle_, 5000);
  try {
    Execute("PRAGMA journal_mode=DELETE");
    Execute("PRAGMA synchronous=EXTRA");
    Execute("PRAGMA foreign_keys=ON");
  } catch (...) {
    sqlite3_close(handle_);
    throw;
  }
}

Database::~Database() {
  sqlite3_close(handle_);
}

void Database::Execute(const std::string& sql) {
  if (sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) Fail(handle_, sql);
}

void Database::Transaction(const std::function<void()>& body) {
  Execute("BEGIN IMMEDIATE");
  try {
    body();
    Execute("COMMIT");
  } catch (...) {
    sqlite3_exec(handle_, "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

int64_t Database::LastRowId() const {
  return sqlite3_last_insert_rowid(handle_);
}

Statement::Statement(Database& database, std::string_view sql) : database_(database) {
  if (sqlite3_prepare_v2(database.handle(), sql.data(), static_cast<int>(sql.size()), &statement_, nullptr) !=
      SQLITE_OK) {
    Fail(database.handle(), "preparing " + std::string(sql));
  }
}
Statement::~Statement() {
  sqlite3_finalize(statement_);
}

Statement& Statement::Bind(int64_t value) {
  if (sqlite3_bind_int64(statement_, ++bound_, value) != SQLITE_OK) Fail(database_.handle(), "binding a number");
  return *this;
}
Statement& Statement::Bind(std::string_view value) {
  if (sqlite3_bind_text64(statement_, ++bound_, value.data() ? value.data() : "", value.size(), SQLITE_TRANSIENT,
                          SQLITE_UTF8) != SQLITE_OK) {
    Fail(database_.handle(), "binding a text");
  }
  return *this;
}
Statement& Statement::BindBlob(std::string_view value) {
  if (sqlite3_bind_blob64(statement_, ++bound_, value.data() ? value.data() : "", value.size(), SQLITE_TRANSIENT) !=
      SQLITE_OK)
    Fail(database_.handle(), "binding bytes");
  return *this;
}

bool Statement::Step() {
  switch (sqlite3_step(statement_)) {
    case SQLITE_ROW:
      return true;
    case SQLITE_DONE:
      return false;
    default:
      Fail(database_.handle(), sqlite3_sql(statement_));
  }
}

int64_t Statement::Integer(int column) const {
  return sqlite3_column_int64(statement_, column);
}
std::string Statement::Text(int column) const {
  const void* data = sqlite3_column_blob(statement_, column);
  return data ? std::string(static_cast<const char*>(data),
                            static_cast<size_t>(sqlite3_column_bytes(statement_, column)))
              : std::string();
}

}  // namespace lodestar
