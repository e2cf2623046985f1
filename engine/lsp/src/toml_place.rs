//! Where in a TOML file the cursor is, although the file is being typed and may be no TOML: the table by its header, the key by its line.

/// The surroundings of the cursor.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct TomlPlace {
    /// The names of the header above: `["passes", "push"]` for `[passes.push]`, and of inline tables around the cursor.
    pub table: Vec<String>,
    /// The key whose value the cursor is in; `None` where a key is typed.
    pub key: Option<String>,
    /// The cursor is between quotes.
    pub in_string: bool,
    /// Texts that are written under the same header, by key: `op = "sphere"` says which operation a table is.
    pub written: Vec<(String, String)>,
}

impl TomlPlace {
    /// The place of a byte of a text.
    pub(crate) fn of(text: &str, at: usize) -> Self {
        let before = text.get(..at).unwrap_or(text);
        let start = before.rfind('\n').map_or(0, |end| end + 1);
        let header = text[..start].lines().rev().find_map(header);
        let mut place = Self { table: header.unwrap_or_default(), ..Self::default() };
        place.entry(&before[entry_start(text, start)..]);
        let above = text[..start].lines().rev().take_while(|line| self::header(line).is_none());
        let below = text[start..].lines().skip(1).take_while(|line| self::header(line).is_none());
        place.written = above.chain(below).filter_map(written).collect();
        place
    }

    /// Follows a key and its value up to the cursor through quotes and inline tables.
    fn entry(&mut self, entry: &str) {
        let (mut word, mut quote, mut in_comment) = (String::new(), None, false);
        let mut keys: Vec<Option<String>> = Vec::new();
        for letter in entry.chars() {
            if letter == '\n' {
                (quote, in_comment) = (None, false);
            } else if in_comment {
                continue;
            }
            if let Some(open) = quote {
                if letter == open {
                    quote = None;
                } else {
                    word.push(letter);
                }
                continue;
            }
            match letter {
                '"' | '\'' => {
                    quote = Some(letter);
                    word.clear();
                }
                '#' => in_comment = true,
                '=' => self.key = Some(std::mem::take(&mut word)),
                '{' => {
                    keys.push(self.key.take());
                    self.table.extend(keys.last().cloned().flatten());
                    word.clear();
                }
                '}' => {
                    if keys.pop().flatten().is_some() {
                        self.table.pop();
                    }
                    self.key = None;
                    word.clear();
                }
                ',' => {
                    // In an array the key stays; in an inline table the next one begins.
                    if !keys.is_empty() {
                        self.key = None;
                    }
                    word.clear();
                }
                letter if letter.is_whitespace() => {}
                letter => word.push(letter),
            }
        }
        self.in_string = quote.is_some();
    }
}

/// The start of the entry that the line at a byte belongs to. The array of an entry may have several lines, which begin with no key.
fn entry_start(text: &str, line: usize) -> usize {
    let begins = |line: &str| line.trim_start().starts_with(|c: char| c.is_alphabetic() || c == '_');
    let is_begun = text[line..].lines().next().is_some_and(begins);
    if is_begun {
        return line;
    }
    let mut start = line;
    for above in text[..line].split_inclusive('\n').rev() {
        if header(above).is_some() {
            return line;
        }
        start -= above.len();
        if begins(above) {
            break;
        }
    }
    let mut depth = 0_i32;
    let (mut quote, mut in_comment) = (None, false);
    for letter in text[start..line].chars() {
        match (letter, quote) {
            ('\n', _) => (quote, in_comment) = (None, false),
            (letter, Some(open)) if letter == open => quote = None,
            ('"' | '\'', None) if !in_comment => quote = Some(letter),
            ('#', None) => in_comment = true,
            ('[', None) if !in_comment => depth += 1,
            (']', None) if !in_comment => depth -= 1,
            _ => {}
        }
    }
    if depth > 0 { start } else { line }
}

/// The names in front of the one that is typed at a byte, if that is in the header of a table: `targets` in `[targets.co`.
pub(super) fn header_at(text: &str, at: usize) -> Option<Vec<String>> {
    // Rows of an array are indented.
    let line = text.get(..at)?.rsplit('\n').next()?;
    let inner = line.strip_prefix('[').map(|inner| inner.strip_prefix('[').unwrap_or(inner))?;
    if inner.contains([']', '=', ',', '"']) || inner.starts_with(|c: char| !c.is_alphabetic()) {
        return None;
    }
    let mut names: Vec<String> = inner.split('.').map(|name| name.trim().to_owned()).collect();
    names.pop();
    Some(names)
}

/// The key and the text of a line `key = "text"`.
fn written(line: &str) -> Option<(String, String)> {
    let (key, value) = line.split_once('=')?;
    Some((key.trim().to_owned(), quoted(value)?.to_owned()))
}

/// The text of a value that is one, in quotes of either kind.
pub(super) fn quoted(value: &str) -> Option<&str> {
    let value = value.trim_start();
    let quote = value.chars().next().filter(|letter| matches!(letter, '"' | '\''))?;
    value[1..].split(quote).next()
}

/// The names of a line that is a header.
fn header(line: &str) -> Option<Vec<String>> {
    let line = line.trim();
    let inner = line.strip_prefix('[')?.trim_start_matches('[').split(']').next()?;
    let names: Vec<String> = inner.split('.').map(|name| name.trim().trim_matches(['"', '\'']).to_owned()).collect();
    // An array of several lines has brackets at the beginning of lines, too.
    let is_name = |name: &String| name.chars().all(|c| c.is_alphanumeric() || "_- ".contains(c));
    (names.iter().all(is_name) && names[0].chars().next().is_some_and(char::is_alphabetic)).then_some(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(text: &str) -> (Vec<String>, Option<String>, bool) {
        let at = text.find('|').unwrap();
        let found = TomlPlace::of(&text.replace('|', ""), at);
        (found.table, found.key, found.in_string)
    }

    #[test]
    fn tables_keys_and_strings() {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        assert_eq!(place("pre|"), (names(&[]), None, false));
        assert_eq!(place("[[passes]]\nname = \"a\"\nsha|"), (names(&["passes"]), None, false));
        assert_eq!(place("[[passes]]\nshader = \"pri|\""), (names(&["passes"]), Some("shader".into()), true));
        assert_eq!(
            place("[passes.push]\nfov = { from = \"cam|"),
            (names(&["passes", "push", "fov"]), Some("from".into()), true)
        );
        assert_eq!(
            place("[passes.push]\nfov = { type = \"f32\", fr|"),
            (names(&["passes", "push", "fov"]), None, false)
        );
        assert_eq!(
            place("[[passes]]\nbind = { world = \"w\", hit = \"|"),
            (names(&["passes", "bind"]), Some("hit".into()), true)
        );
        assert_eq!(
            place("[targets.color]\nclear = [0.0, |"),
            (names(&["targets", "color"]), Some("clear".into()), false)
        );
        assert_eq!(
            place("[[edits]]\n[tracks.]\n|"),
            (names(&["tracks", ""]), None, false),
            "a name that is not typed yet"
        );
        assert_eq!(place("[a]\n# [b] |"), (names(&["a"]), None, false));
        assert_eq!(place("[[build]]\nmin = [\n  [1, 2],\n  |"), (names(&["build"]), Some("min".into()), false));
        let keys = "[inputs]\nkeys = [  # \"]\n\n  [0.0, [\"KeyW\"]],\n  [1.0, [\"";
        assert_eq!(place(&format!("{keys}|")), (names(&["inputs"]), Some("keys".into()), true));
        assert_eq!(place(&format!("{keys}\"]],\n]\n|")), (names(&["inputs"]), None, false));
        assert_eq!(place(&format!("{keys}\nbut|")), (names(&["inputs"]), None, false), "an array without its end");
        assert_eq!(place("[[a]]\nb = [\n  { c = 1, d|"), (names(&["a", "b"]), None, false));
    }
}
