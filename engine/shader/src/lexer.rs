//! Just enough of a lexer for GLSL and HLSL: where comments and words are.

use std::ops::Range;

/// Byte ranges of the lines, without their ends.
pub(crate) fn line_ranges(text: &str) -> Vec<Range<usize>> {
    let mut ranges = Vec::new();
    let mut start = 0;
    for line in text.split('\n') {
        let content = line.strip_suffix('\r').unwrap_or(line);
        ranges.push(start..start + content.len());
        start += line.len() + 1;
    }
    ranges
}

/// Number of the line that a byte is on, from 1.
pub(crate) fn line_of(text: &str, at: usize) -> usize {
    text[..at].matches('\n').count() + 1
}

/// Whether a character is part of an identifier or number.
pub(crate) fn is_word(c: char) -> bool {
    c == '_' || c.is_alphanumeric()
}

/// Where `word` stands in `text`: for an identifier, not as a part of a longer one.
pub(crate) fn find_word(text: &str, word: &str) -> Option<usize> {
    let identifier = word.chars().all(is_word);
    text.match_indices(word).map(|(at, _)| at).find(|at| {
        !identifier
            || !(text[..*at].chars().next_back().is_some_and(is_word)
                || text[at + word.len()..].chars().next().is_some_and(is_word))
    })
}

/// One token: an identifier, a number (without the sign of its exponent), or one other character that is no white space.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Token<'t> {
    pub text: &'t str,
    pub at: usize,
}

impl Token<'_> {
    pub(crate) fn range(&self) -> Range<usize> {
        self.at..self.at + self.text.len()
    }

    /// Whether it is an identifier or a number.
    pub(crate) fn is_word(&self) -> bool {
        self.text.starts_with(is_word) || (self.text.len() > 1 && self.text.starts_with('.'))
    }

    pub(crate) fn is_identifier(&self) -> bool {
        self.text.starts_with(|c: char| c == '_' || c.is_alphabetic())
    }
}

/// The tokens of a text in order, without comments and white space.
pub(crate) fn tokens(text: &str) -> Vec<Token<'_>> {
    let bytes = text.as_bytes();
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(&first) = bytes.get(at) {
        let next = bytes.get(at + 1).copied().unwrap_or_default();
        at += match (first, next) {
            (b'/', b'/') => line_comment(&text[at..]),
            (b'/', b'*') => comment(&text[at..]),
            _ if first.is_ascii_whitespace() => 1,
            _ => {
                let number = first.is_ascii_digit() || (first == b'.' && next.is_ascii_digit());
                let token = Token { text: &text[at..][..token_bytes(&text[at..], number)], at };
                let length = token.text.len();
                tokens.push(token);
                length
            }
        };
    }
    tokens
}

/// Bytes of the token that begins a text. A number may have points in it.
fn token_bytes(text: &str, number: bool) -> usize {
    let plain = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_' || (number && *byte == b'.');
    let end = text.bytes().position(|byte| !plain(&byte)).unwrap_or(text.len());
    let rest = &text[end..];
    let length = if text.as_bytes().get(end).is_none_or(u8::is_ascii) {
        end
    } else {
        end + rest.find(|c| !(is_word(c) || (number && c == '.'))).unwrap_or(rest.len())
    };
    // Any other character is a token of its own.
    if length == 0 { text.chars().next().map_or(0, char::len_utf8) } else { length }
}

/// Bytes of a comment up to the end of its line; a `\` there carries it on.
pub(crate) fn line_comment(text: &str) -> usize {
    let mut ends = text.match_indices('\n').map(|(at, _)| at);
    ends.find(|at| !text[..*at].trim_end_matches('\r').ends_with('\\')).unwrap_or(text.len())
}

/// Bytes of a comment between marks; without the second mark, all bytes.
pub(crate) fn comment(text: &str) -> usize {
    text[2..].find("*/").map_or(text.len(), |end| end + 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skips_comments() {
        let text = "a/* b */ c// d\n_e1+2.5e3*.5-p.x /* f";
        let words: Vec<_> = tokens(text).iter().map(|token| token.text).collect();
        assert_eq!(words, ["a", "c", "_e1", "+", "2.5e3", "*", ".5", "-", "p", ".", "x"]);
        assert!(tokens("/*/").is_empty());
        assert!(tokens("// a \\\n b \\\r\n c").is_empty());
        let words: Vec<_> = tokens("é1+aé.b 1.é.2é.. .é漢\u{a0}x").iter().map(|token| token.text).collect();
        assert_eq!(words, ["é1", "+", "aé", ".", "b", "1.é.2é..", ".", "é漢", "\u{a0}", "x"]);
    }

    #[test]
    fn finds_whole_words() {
        assert_eq!(find_word("foobar foo", "foo"), Some(7));
        assert_eq!(find_word("a += 1", "+="), Some(2));
        assert_eq!(find_word("foobar", "foo"), None);
    }
}
