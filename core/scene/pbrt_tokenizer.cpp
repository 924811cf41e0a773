#include "core/scene/pbrt_tokenizer.h"

namespace lodestar {
namespace {

bool IsSpace(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v';
}
bool EndsWord(char c) {
  return IsSpace(c) || c == '"' || c == '[' || c == ']' || c == '#';
}

}  // namespace

void FailAt(const SourceLocation& where, ErrorKind kind, const std::string& message) {
  throw Error(kind, where.ToString() + ": " + message);
}

std::optional<Token> Tokenizer::Next() {
  if (!peeked_) return Scan();
  peeked_ = false;
  return std::move(ahead_);
}

const std::optional<Token>& Tokenizer::Peek() {
  if (!peeked_) {
    ahead_ = Scan();
    peeked_ = true;
  }
  return ahead_;
}

void Tokenizer::Advance() {
  if (text_[at_++] == '\n') {
    ++line_;
    column_ = 1;
  } else {
    ++column_;
  }
}

void Tokenizer::SkipSpaceAndComments() {
  while (at_ < text_.size()) {
    if (IsSpace(text_[at_])) {
      Advance();
    } else if (text_[at_] == '#') {
      while (at_ < text_.size() && text_[at_] != '\n') Advance();
    } else {
      return;
    }
  }
}

std::optional<Token> Tokenizer::Scan() {
  SkipSpaceAndComments();
  if (at_ == text_.size()) return std::nullopt;
  if (text_[at_] == '"') return ScanString();
  if (text_[at_] == '[' || text_[at_] == ']') {
    Token token = StartToken(text_[at_] == '[' ? Token::Kind::kOpen : Token::Kind::kClose);
    token.text = text_[at_];
    Advance();
    return token;
  }
  Token token = StartToken(Token::Kind::kWord);
  const size_t start = at_;
  while (at_ < text_.size() && !EndsWord(text_[at_])) ++at_;
  column_ += static_cast<int>(at_ - start);  // a word stays on its line
  token.text = text_.substr(start, at_ - start);
  return token;
}

Token Tokenizer::StartToken(Token::Kind kind) const {
  Token token;
  token.kind = kind;
  token.file = file_;
  token.line = line_;
  token.column = column_;
  return token;
}

Token Tokenizer::ScanString() {
  Token token = StartToken(Token::Kind::kString);
  Advance();
  while (true) {
    if (at_ == text_.size() || text_[at_] == '\n')
      FailAt(token.where(), ErrorKind::kInvalidInput, "this string has no closing quote on its line");
    char c = text_[at_];
    if (c == '"') break;
    if (c == '\\') {
      const SourceLocation escape = Here();
      Advance();
      if (at_ == text_.size()) continue;
      switch (text_[at_]) {
        case 'b':
          c = '\b';
          break;
        case 'f':
          c = '\f';
          break;
        case 'n':
          c = '\n';
          break;
        case 'r':
          c = '\r';
          break;
        case 't':
          c = '\t';
          break;
        case '\\':
          c = '\\';
          break;
        case '\'':
          c = '\'';
          break;
        case '"':
          c = '"';
          break;
        default:
          FailAt(escape, ErrorKind::kInvalidInput,
                 std::string("unknown escape \"\\") + text_[at_] + "\"; write \\\\ for a backslash");
      }
    }
    token.text += c;
    Advance();
  }
  Advance();
  return token;
}

}  // namespace lodestar
