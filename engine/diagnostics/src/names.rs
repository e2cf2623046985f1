//! Names and numbers in messages: the name that was meant, a list of those there are, and large numbers.

/// Compares a misspelt name with known names: first by their letters, then by edits if the letters allow it. A file may have thousands of
/// mistakes and thousands of names.
const MOST_COMPARED: usize = 2000;
const MOST_EDITED: usize = 200;

/// The name closest to a misspelt one, if one of the first `MOST_COMPARED` is close enough to be meant. There is
/// none for a name of more than 64 bytes.
pub fn closest<'n>(wrong: &str, names: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    if wrong.len() > 64 {
        return None;
    }
    let limit = (wrong.chars().count() / 3).max(1);
    let letters = Letters::of(wrong);
    let wrong = wrong.to_lowercase();
    // Of equally distant names, the one that begins alike is the one that was meant.
    let alike = |name: &str| wrong.bytes().zip(name.bytes()).take_while(|(a, b)| a == b).count();
    names
        .take(MOST_COMPARED)
        // Each character more or less is one edit; a character has up to four bytes.
        .filter(|name| name.len() <= 4 * (wrong.len() + limit) && 4 * (name.len() + limit) >= wrong.len())
        .filter(|name| letters.least_edits(&Letters::of(name)) <= limit)
        .take(MOST_EDITED)
        .map(|name| (strsim::damerau_levenshtein(&wrong, &name.to_lowercase()), name))
        .filter(|(distance, _)| *distance <= limit)
        .min_by_key(|(distance, name)| (*distance, std::cmp::Reverse(alike(&name.to_lowercase())), *name))
        .map(|(_, name)| name)
}

/// How often each letter is in a word, without regard to case and order; letters beyond ASCII count as one.
struct Letters([u16; 33]);

impl Letters {
    fn of(word: &str) -> Letters {
        let mut counts = [0; 33];
        for letter in word.chars() {
            counts[if letter.is_ascii() { usize::from(letter as u8 & 31) } else { 32 }] += 1;
        }
        Letters(counts)
    }

    /// No fewer edits lead from one word to the other: each adds one letter, removes one, or replaces one.
    fn least_edits(&self, other: &Letters) -> usize {
        let excess = |a: &Letters, b: &Letters| -> usize {
            a.0.iter().zip(&b.0).map(|(a, b)| usize::from(a.saturating_sub(*b))).sum()
        };
        excess(self, other).max(excess(other, self))
    }
}

/// Names as a list for a message: `a`, `b`, `c`.
pub fn list<'n>(names: impl Iterator<Item = &'n str>) -> String {
    names.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// A number with a comma at each thousand: `99,980`.
pub fn grouped(number: impl std::fmt::Display) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A number of things: `1 lamp`, `12,345 lamps`.
pub fn counted(count: u64, what: &str) -> String {
    format!("{} {what}{}", grouped(count), if count == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_apart() {
        assert_eq!([12, 999, 1000, 1_234_567].map(grouped), ["12", "999", "1,000", "1,234,567"]);
        assert_eq!([0, 1, 2000].map(|count| counted(count, "lamp")), ["0 lamps", "1 lamp", "2,000 lamps"]);
    }

    #[test]
    fn the_closest_name_is_near() {
        assert_eq!(closest("colour", ["color", "depth", "c"].into_iter()), Some("color"));
        assert_eq!(closest("é", ["e", "depth"].into_iter()), Some("e"));
        assert_eq!(closest("depht", std::iter::once("exposure")), None);
        assert_eq!(closest(&"x".repeat(1 << 20), std::iter::once("x")), None);
        // Differences that the counts of letters rule out, and others: case, order, one more, one less.
        for (wrong, name) in
            [("DEPTH", "depth"), ("dpeth", "depth"), ("depht1", "depth"), ("größe", "größen"), ("a_b", "a-b")]
        {
            assert_eq!(closest(wrong, ["zzzzz", name].into_iter()), Some(name));
        }
        assert_eq!(
            closest("depth", std::iter::repeat_n("width", 3000).chain(["depht"])),
            None,
            "only so many are compared"
        );
    }
}
