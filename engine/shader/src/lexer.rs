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
    pub fn range(&self) -> Range<usize> {
        self.at..self.at + self.text.len()
    }

    /// Whether it is an identifier or a number.
    pub fn is_word(&self) -> bool {
        self.text.starts_with(is_word) || (self.text.len() > 1 && self.text.starts_with('.'))
    }

    pub fn is_identifier(&self) -> bool {
        self.text.starts_with(|c: char| c == '_' || c.is_alphabetic())
    }
}

/// The tokens of a text in order, without comments and white space.
pub(crate) fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        let length = if c == '/' && rest.starts_with("//") {
            // A `\` at the end of the line carries the comment on.
            let end = rest.match_indices('\n').find(|(at, _)| !rest[..*at].trim_end_matches('\r').ends_with('\\'));
            end.map_or(rest.len(), |(at, _)| at)
        } else if c == '/'
            && let Some(comment) = rest.strip_prefix("/*")
        {
            comment.find("*/").map_or(rest.len(), |end| end + 4)
        } else if c.is_ascii_whitespace() {
            rest.find(|c: char| !c.is_ascii_whitespace()).unwrap_or(rest.len())
        } else {
            let number = c.is_ascii_digit() || (c == '.' && rest[1..].starts_with(|c: char| c.is_ascii_digit()));
            let length = if number {
                rest.find(|c| !is_word(c) && c != '.').unwrap_or(rest.len())
            } else if is_word(c) {
                rest.find(|c| !is_word(c)).unwrap_or(rest.len())
            } else {
                c.len_utf8()
            };
            tokens.push(Token { text: &rest[..length], at });
            length
        };
        at += length;
    }
    tokens
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
    }

    #[test]
    fn finds_whole_words() {
        assert_eq!(find_word("foobar foo", "foo"), Some(7));
        assert_eq!(find_word("a += 1", "+="), Some(2));
        assert_eq!(find_word("foobar", "foo"), None);
    }
}
