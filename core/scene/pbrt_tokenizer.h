// The words of a pbrt-v4 file: bare words and numbers, quoted strings, brackets; # starts a comment that ends with the
// line.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/scene/description.h"

namespace lodestar {

// Every error of the parser: "file:line:column: message".
[[noreturn]] void FailAt(const SourceLocation& where, ErrorKind kind, const std::string& message);

struct Token {
  enum class Kind { kWord, kString, kOpen, kClose } kind = Kind::kWord;
  std::string text;                         // of a string: without its quotes, escapes resolved
  std::shared_ptr<const std::string> file;  // shared: a mesh written inline has millions of tokens
  int line = 0, column = 0;
  SourceLocation where() const { return {*file, line, column}; }
  bool IsWord(std::string_view word) const { return kind == Kind::kWord && text == word; }
};

class Tokenizer {
 public:
  Tokenizer(std::string text, std::string file)
      : text_(std::move(text)), file_(std::make_shared<const std::string>(std::move(file))) {}

  // The next token, or nothing at the end. Throws Error(kInvalidInput) for an unterminated string or an unknown escape.
  std::optional<Token> Next();
  // What Next() will return.
  const std::optional<Token>& Peek();
  // The place just after the last character read.
  SourceLocation Here() const { return {*file_, line_, column_}; }

 private:
  std::optional<Token> Scan();
  Token StartToken(Token::Kind kind) const;
  Token ScanString();
  void SkipSpaceAndComments();
  void Advance();

  std::string text_;
  std::shared_ptr<const std::string> file_;
  size_t at_ = 0;
  int line_ = 1, column_ = 1;  // of text_[at_]; columns count bytes
  bool peeked_ = false;
  std::optional<Token> ahead_;
};

}  // namespace lodestar
