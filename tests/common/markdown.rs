//! Markdown as far as tests read it: lines, fenced blocks, links and headings.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::repository;

/// A line of a page.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// From 1.
    pub number: usize,
    /// Whether it is inside a fenced block.
    pub fenced: bool,
    pub text: String,
}

/// The lines of a page, without those that open and close fenced blocks.
pub(crate) fn lines(page: &str) -> Vec<Line> {
    let mut fenced = false;
    let mut found = Vec::new();
    for (index, text) in page.lines().enumerate() {
        if text.starts_with("```") {
            fenced = !fenced;
        } else {
            found.push(Line { number: index + 1, fenced, text: text.to_owned() });
        }
    }
    found
}

/// A fenced block.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// The line that opens it, from 1.
    pub number: usize,
    /// The words behind the fence; the first is the language.
    pub info: Vec<String>,
    /// Its lines, each with its end.
    pub text: String,
}

impl Block {
    /// The text after `name=` in the info words.
    pub(crate) fn value(&self, name: &str) -> Option<&str> {
        self.info.iter().find_map(|word| word.strip_prefix(name)?.strip_prefix('='))
    }

    /// The language.
    pub(crate) fn language(&self) -> &str {
        self.info.first().map_or("", String::as_str)
    }
}

/// The fenced blocks of a page.
pub(crate) fn blocks(page: &str) -> Vec<Block> {
    let mut found = Vec::new();
    let mut open: Option<Block> = None;
    for (index, text) in page.lines().enumerate() {
        match (text.strip_prefix("```"), open.as_mut()) {
            (Some(_), Some(_)) => found.extend(open.take()),
            (Some(info), None) => {
                let info = info.split_whitespace().map(str::to_owned).collect();
                open = Some(Block { number: index + 1, info, text: String::new() });
            }
            (None, Some(block)) => block.text += &format!("{text}\n"),
            (None, None) => {}
        }
    }
    found
}

/// The code spans of a line.
pub(crate) fn spans(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

/// The targets of a line's links and pictures, except for other sites.
pub(crate) fn links(line: &str) -> impl Iterator<Item = &str> {
    let targets = line.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets.filter(|target| !target.contains("://"))
}

/// The anchor of a heading, as GitHub and mdBook make it.
pub(crate) fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    kept.chars().filter(|c| c.is_alphanumeric() || "-_ ".contains(*c)).map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// Whether a page has a heading with that anchor.
fn has_anchor(page: &str, wanted: &str) -> bool {
    headings(page).any(|heading| anchor(&heading) == wanted)
}

/// The headings of a page, without their marks.
pub(crate) fn headings(page: &str) -> impl Iterator<Item = String> {
    let marked = lines(page).into_iter().filter(|line| !line.fenced && line.text.starts_with('#'));
    marked.map(|line| line.text.trim_start_matches('#').trim().to_owned())
}

/// The links of a page of the repository that lead nowhere, each with its page and line, and how many links there are.
pub(crate) fn dead_links(page: &str) -> (Vec<String>, usize) {
    let folder = Path::new(page).parent().unwrap_or(Path::new(""));
    let (mut dead, mut count) = (Vec::new(), 0);
    let text = std::fs::read_to_string(repository().join(page)).unwrap_or_else(|error| panic!("{page}: {error}"));
    for line in lines(&text).into_iter().filter(|line| !line.fenced) {
        for target in links(&line.text) {
            count += 1;
            let at = format!("{page}:{}", line.number);
            let (path, heading) =
                target.split_once('#').map_or((target, None), |(path, heading)| (path, Some(heading)));
            let file = if path.is_empty() { PathBuf::from(page) } else { folder.join(path) };
            let on_disk = repository().join(&file);
            if !on_disk.exists() {
                dead.push(format!("{at}: {path} does not exist"));
            } else if let Some(heading) = heading {
                let there = std::fs::read_to_string(&on_disk).is_ok_and(|text| has_anchor(&text, heading));
                if !there {
                    dead.push(format!("{at}: {} has no heading #{heading}", file.display()));
                }
            }
        }
    }
    (dead, count)
}

/// The pages of a folder of the repository and those below it.
pub(crate) fn pages(folder: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(repository().join(folder)).unwrap() {
        let path = format!("{folder}/{}", entry.unwrap().file_name().to_str().unwrap());
        if repository().join(&path).is_dir() {
            found.extend(pages(&path));
        } else if Path::new(&path).extension().is_some_and(|extension| extension == "md") {
            found.insert(path);
        }
    }
    found
}
