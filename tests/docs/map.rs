//! `ARCHITECTURE.md` and `CONTRIBUTING.md` name files, functions, crates and commands. A page that names missing things misleads the heirs
//! of the code, so everything that they name is looked up here.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use raxel_rivals as rivals;

use crate::common::markdown::{self, spans};
use crate::common::{raxel, repository};
use crate::pieces::OTHERS;

const PAGES: [&str; 2] = ["ARCHITECTURE.md", "CONTRIBUTING.md"];

fn read(path: impl AsRef<Path>) -> String {
    let path = repository().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The mistakes, each with its page and line.
type Faults = Vec<String>;

fn fails_with(faults: &Faults) {
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The lines of a page with their numbers, and whether each is inside a fenced block.
fn lines(page: &str) -> Vec<(usize, bool, String)> {
    let lines = markdown::lines(&read(page)).into_iter();
    lines.map(|line| (line.number, line.fenced, line.text)).collect()
}

/// The Rust sources at a path or below it, and the launcher.
fn sources(path: &Path, found: &mut Vec<PathBuf>) {
    if path.is_dir() {
        let mut entries: Vec<PathBuf> = std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()).collect();
        entries.sort();
        entries.iter().for_each(|entry| sources(entry, found));
    } else if path.extension().is_some_and(|extension| extension == "rs") || path.ends_with("raxel") {
        found.push(path.to_owned());
    }
}

fn texts(paths: &[PathBuf]) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    paths.iter().for_each(|path| sources(path, &mut found));
    found.into_iter().map(|path| (path.clone(), read(path))).collect()
}

fn is_word(c: char) -> bool {
    c == '_' || c.is_ascii_alphanumeric()
}

/// Whether a source declares something of that name.
fn declares(source: &str, name: &str) -> bool {
    const KINDS: [&str; 8] = ["fn ", "struct ", "enum ", "trait ", "const ", "static ", "type ", "mod "];
    source.match_indices(name).any(|(at, _)| {
        KINDS.iter().any(|kind| source[..at].ends_with(kind)) && !source[at + name.len()..].starts_with(is_word)
    })
}

/// A text that looks like a path of the repository: it has a slash, or the ending of a file that one reads.
fn is_path(span: &str) -> bool {
    let endings = [".rs", ".toml", ".md", ".glsl", ".comp"];
    !span.contains(char::is_whitespace)
        && (span.contains('/') || endings.iter().any(|ending| span.len() > ending.len() && span.ends_with(ending)))
}

#[test]
fn paths_and_names_are_there() {
    let (mut faults, mut paths, mut names) = (Faults::new(), 0, 0);
    for page in PAGES {
        for (number, _, line) in lines(page).into_iter().filter(|(_, fenced, _)| !fenced) {
            let mut last: Option<PathBuf> = None;
            for span in spans(&line).filter(|span| *span != "::") {
                let (path, name) = match span.split_once("::") {
                    Some((path, name)) => (path, Some(name)),
                    None => (span, None),
                };
                if is_path(path) {
                    paths += 1;
                    last = Some(repository().join(path));
                    if !repository().join(path).exists() {
                        faults.push(format!("{page}:{number}: `{path}` does not exist"));
                        continue;
                    }
                } else if !path.is_empty() || name.is_none() {
                    continue;
                }
                let Some(name) = name else { continue };
                names += 1;
                match &last {
                    None => faults.push(format!("{page}:{number}: `{span}` has no path before it")),
                    Some(file) if file.is_file() && declares(&read(file), name) => {}
                    Some(file) => {
                        let file = file.strip_prefix(repository()).unwrap().display();
                        faults.push(format!("{page}:{number}: `{name}` is not in {file}"));
                    }
                }
            }
        }
    }
    fails_with(&faults);
    assert!(paths > 150 && names > 80, "{paths} paths and {names} names were found");
}

#[test]
fn links_lead_somewhere() {
    let (mut faults, mut links) = (Faults::new(), 0);
    let roots = PAGES.into_iter().chain(OTHERS).map(str::to_owned);
    for page in roots.chain(markdown::pages("docs")) {
        let (dead, count) = markdown::dead_links(&page);
        faults.extend(dead);
        links += count;
    }
    fails_with(&faults);
    assert!(links > 300, "{links} links");
}

/// Words in italics call rows of the tables in `ARCHITECTURE.md` by their first column.
#[test]
fn steps_are_rows() {
    let rows: BTreeSet<String> = lines("ARCHITECTURE.md")
        .iter()
        .filter_map(|(_, _, line)| Some(line.strip_prefix("| ")?.split(" | ").next()?.to_owned()))
        .collect();
    // A word that the page explains, and the title of a part of the guides.
    let others = ["Regenerate", "Every key"];
    let (mut faults, mut steps) = (Faults::new(), 0);
    for page in PAGES {
        for (number, _, line) in lines(page).into_iter().filter(|(_, fenced, _)| !fenced) {
            let line = line.strip_prefix("* ").unwrap_or(&line).replace("**", "");
            let plain: String = line.split('`').step_by(2).collect();
            for step in plain.split('*').skip(1).step_by(2).filter(|step| !others.contains(step)) {
                steps += 1;
                if !rows.contains(step) {
                    faults.push(format!("{page}:{number}: no row is called *{step}*"));
                }
            }
        }
    }
    fails_with(&faults);
    assert!(steps > 20, "{steps} steps");
}

/// A crate of the workspace.
struct Package {
    name: String,
    folder: PathBuf,
    /// Crates of the workspace that it is built with, tests left out.
    uses: BTreeSet<String>,
    /// Benchmarks that its manifest names.
    benches: BTreeSet<String>,
}

impl Package {
    fn read(folder: &Path) -> Self {
        let manifest: toml::Table = read(folder.join("Cargo.toml")).parse().unwrap();
        let tables = ["dependencies", "build-dependencies"];
        let targets = manifest.get("target").and_then(toml::Value::as_table).into_iter().flat_map(toml::Table::values);
        let scopes = targets.filter_map(toml::Value::as_table).chain([&manifest]);
        let all = scopes.flat_map(|scope| tables.iter().filter_map(|table| scope.get(*table)?.as_table()));
        let uses = all.flat_map(toml::Table::keys).filter(|name| name.starts_with("raxel")).cloned().collect();
        let benches = manifest.get("bench").and_then(toml::Value::as_array).into_iter().flatten();
        let benches = benches.map(|bench| bench["name"].as_str().unwrap().to_owned()).collect();
        let name = manifest["package"]["name"].as_str().unwrap().to_owned();
        Self { name, folder: folder.to_owned(), uses, benches }
    }
}

/// The crates of the workspace by name, the root among them.
fn packages() -> BTreeMap<String, Package> {
    let root: toml::Table = read("Cargo.toml").parse().unwrap();
    let members = root["workspace"]["members"].as_array().unwrap().iter().map(|member| member.as_str().unwrap());
    let all = members.chain([""]).map(|member| Package::read(&repository().join(member)));
    all.map(|package| (package.name.clone(), package)).collect()
}

/// Whether a crate is built with `raxel-gpu`, or is it.
fn knows_vulkan(name: &str, packages: &BTreeMap<String, Package>) -> bool {
    name == "raxel-gpu" || packages[name].uses.iter().any(|used| knows_vulkan(used, packages))
}

fn allows_unsafe(package: &Package) -> bool {
    let lifted = ["allow(unsafe_code", "expect(unsafe_code"];
    texts(&[package.folder.join("src")]).iter().any(|(_, text)| lifted.iter().any(|word| text.contains(word)))
}

#[test]
fn the_map_has_every_crate_behind_those_it_uses() {
    let packages = packages();
    let (mut faults, mut seen) = (Faults::new(), BTreeSet::new());
    for (number, _, line) in lines("ARCHITECTURE.md") {
        let Some(row) = line.strip_prefix("| `raxel") else { continue };
        let at = format!("ARCHITECTURE.md:{number}");
        let cells: Vec<&str> = row.trim_end_matches([' ', '|']).split(" | ").collect();
        let [name, folder, duty, is_unsafe, vulkan] = cells[..] else { panic!("{at}: {} cells", cells.len()) };
        let name = format!("raxel{}", name.trim_end_matches('`'));
        let Some(package) = packages.get(&name) else {
            faults.push(format!("{at}: there is no crate `{name}`"));
            continue;
        };
        if !seen.insert(name.clone()) {
            faults.push(format!("{at}: `{name}` is there twice"));
        }
        for used in package.uses.difference(&seen) {
            faults.push(format!("{at}: `{name}` stands before `{used}`, which it uses"));
        }
        let place = repository().join(folder.trim_matches('`'));
        if place != package.folder && name != "raxel" {
            let folder = package.folder.strip_prefix(repository()).unwrap().display();
            faults.push(format!("{at}: `{name}` is in {folder}"));
        }
        for (what, said, is) in [
            ("unsafe", is_unsafe, allows_unsafe(package) && name != "raxel"),
            ("Vulkan", vulkan, knows_vulkan(&name, &packages)),
        ] {
            if said != if is { "yes" } else { "no" } {
                faults.push(format!("{at}: `{name}` has {said:?} under {what}"));
            }
        }
        if duty.matches(". ").count() > 0 || !duty.ends_with('.') {
            faults.push(format!("{at}: the duty of `{name}` is one sentence"));
        }
    }
    faults.extend(packages.keys().filter(|name| !seen.contains(*name)).map(|name| format!("`{name}` is missing")));
    fails_with(&faults);
}

/// Lines of a source that are no tests.
fn lines_without_tests(text: &str) -> usize {
    text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default().lines().count()
}

/// A crate that grows beyond this is several, and is split by what belongs together.
#[test]
fn no_crate_is_larger_than_a_reader_can_know() {
    const MOST: usize = 9000;
    let mut faults = Faults::new();
    for package in packages().values() {
        let sources = texts(&[package.folder.join("src")]);
        let tests = |path: &Path| path.iter().any(|part| part == "tests" || part == "tests.rs");
        let lines: usize =
            sources.iter().filter(|(path, _)| !tests(path)).map(|(_, text)| lines_without_tests(text)).sum();
        if lines > MOST {
            faults.push(format!(
                "`{}` has {lines} lines that are no tests, and at most {MOST} are allowed",
                package.name
            ));
        }
    }
    fails_with(&faults);
    assert_eq!(lines_without_tests("fn a() {}\n\n#[cfg(test)]\nmod tests {\n    fn b() {}\n}\n"), 2);
}

/// Every command of the pages, with its place.
fn commands() -> Vec<(String, Vec<String>)> {
    let mut found = Vec::new();
    for page in PAGES {
        for (number, fenced, line) in lines(page) {
            let texts: Vec<&str> = if fenced { vec![&line] } else { spans(&line).collect() };
            for text in texts {
                let text = text.split(" #").next().unwrap();
                let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
                // A variable alone, or a program by its name, is no command.
                let program = words.iter().find(|word| !word.contains('='));
                let runs = program.is_some_and(|word| word == "cargo" || word == "./raxel") && words.len() > 1;
                if fenced || runs {
                    found.push((format!("{page}:{number}"), words));
                }
            }
        }
    }
    found
}

#[test]
fn commands_name_what_is_there() {
    let packages = packages();
    let mut faults = Faults::new();
    let programs = texts(&["tests", "engine", "benches", "raxel"].map(|path| repository().join(path)));
    let commands = commands();
    assert!(commands.len() > 45, "{} commands", commands.len());
    for (at, words) in commands {
        let mut words = words.into_iter().peekable();
        while let Some(variable) = words.next_if(|word| word.contains('=')) {
            let name = variable.split('=').next().unwrap();
            // Some programs put the name together: `RAXEL_MUTATION_{name}` with "TO".
            let (head, tail) = name.rsplit_once('_').unwrap_or((name, ""));
            let (composed, part) = (format!("{head}_{{"), format!("\"{tail}\""));
            let known = programs.iter().any(|(path, text)| {
                !path.ends_with("docs/map.rs")
                    && (text.contains(name) || text.contains(&composed) && text.contains(&part))
            });
            // That of insta is read by insta.
            if !known && name != "INSTA_UPDATE" {
                faults.push(format!("{at}: nothing reads {name}"));
            }
        }
        let words: Vec<String> = words.collect();
        let wrong = match words[0].as_str() {
            "cargo" => cargo(&words[1..], &packages),
            "./raxel" => launcher(&words[1..], &packages),
            script if script.starts_with(".github/release/") && repository().join(script).is_file() => Ok(()),
            other => Err(format!("`{other}` is neither cargo nor ./raxel")),
        };
        faults.extend(wrong.err().map(|wrong| format!("{at}: {wrong}")));
    }
    fails_with(&faults);
}

/// The mistake in the arguments of cargo.
fn cargo(words: &[String], packages: &BTreeMap<String, Package>) -> Result<(), String> {
    let verbs = ["test", "bench", "build", "run", "fmt", "clippy"];
    let verb = words[0].as_str();
    if !verbs.contains(&verb) {
        return Err(format!("cargo {verb} is not one of {verbs:?}"));
    }
    let mut package = &packages["raxel"];
    let (mut files, mut filters) = (Vec::new(), Vec::new());
    let mut words = words[1..].iter().take_while(|word| *word != "--");
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} has no value"));
        match word.as_str() {
            "-p" => {
                let name = value()?;
                package = packages.get(name).ok_or_else(|| format!("there is no crate `{name}`"))?;
            }
            "--profile" => {
                let name = value()?;
                if !read("Cargo.toml").contains(&format!("[profile.{name}]")) {
                    return Err(format!("there is no profile `{name}`"));
                }
            }
            "--test" => {
                let name = value()?;
                let places = [format!("tests/{name}.rs"), format!("tests/{name}/main.rs")];
                if !places.iter().any(|place| package.folder.join(place).is_file()) {
                    return Err(format!("`{}` has no test file `{name}`", package.name));
                }
                files.extend([&places[0], &format!("tests/{name}")].map(|place| package.folder.join(place)));
            }
            "--bench" => {
                let name = value()?;
                if !package.benches.contains(name) {
                    return Err(format!("`{}` has no benchmark `{name}`", package.name));
                }
            }
            "--lib" => files.push(package.folder.join("src")),
            "--all" | "--check" | "--release" => {}
            word if word.starts_with('-') => return Err(format!("{word} is not looked up")),
            word => filters.push(word.to_owned()),
        }
    }
    if verb == "run" {
        // The program of raxel-mutation takes a group.
        let groups = read("engine/mutation/src/groups.rs");
        let unknown = filters.iter().find(|group| !groups.contains(&format!("\"{group}\"")));
        return unknown.map_or(Ok(()), |group| Err(format!("there is no group `{group}`")));
    }
    if files.is_empty() {
        files = ["src", "tests"].map(|folder| package.folder.join(folder)).to_vec();
    }
    let files: Vec<PathBuf> = files.into_iter().filter(|file| file.exists()).collect();
    let matches = |filter: &String| {
        texts(&files).iter().any(|(path, text)| {
            path.strip_prefix(&package.folder).unwrap().to_string_lossy().contains(filter)
                || text.split("fn ").skip(1).any(|rest| rest.split('(').next().unwrap().contains(filter))
        })
    };
    match filters.iter().find(|filter| !matches(filter)) {
        Some(filter) => Err(format!("no test is called like `{filter}`")),
        None => Ok(()),
    }
}

/// The mistake in the arguments of the launcher.
fn launcher(words: &[String], packages: &BTreeMap<String, Package>) -> Result<(), String> {
    let verb = words[0].as_str();
    if verb == "test" {
        let mut words = words[1..].iter();
        while let Some(word) = words.next() {
            let known = match word.as_str() {
                "-p" => words.next().is_some_and(|name| packages.contains_key(name)),
                word => {
                    let text = read("raxel");
                    text.contains(&format!("= {word} ]")) || text.contains(&format!(" {word})\n"))
                }
            };
            if !known {
                return Err(format!("./raxel {verb} does not know {word}"));
            }
        }
        return Ok(());
    }
    let of_verb = raxel(&[verb, "--help"]);
    if of_verb.code != 0 {
        return Err(format!("raxel has no verb `{verb}`"));
    }
    let mut help = of_verb.stdout;
    let mut flag = "";
    for (index, word) in words.iter().enumerate().skip(1) {
        if word.starts_with('-') {
            if !help.contains(word.as_str()) {
                return Err(format!("raxel {verb} has no {word}"));
            }
            flag = word;
            continue;
        }
        let layout = |name: &str| name == "own" || rivals::layout(name.split(':').next().unwrap()).is_some();
        let is_file = |path: String| repository().join(path).exists();
        let fits = match std::mem::take(&mut flag) {
            "--worlds" => is_file(format!("worlds/{word}.toml")),
            "--layouts" => word.split(',').all(layout),
            "--library" => is_file(format!("shaders/include/{word}")),
            "--rays" => word.parse::<f64>().is_ok(),
            "--phase" => help.contains(word.as_str()),
            _ if word.starts_with("RX") => is_file(format!("docs/errors/{word}.md")),
            _ if word.contains('/') => is_file(word.clone()),
            // A graph of a bench, or a verb of a verb.
            _ if ["bench", "rivals/march"].iter().any(|folder| is_file(format!("graphs/{folder}/{word}.toml"))) => true,
            _ if index == 1 && help.contains(&format!("\n  {word} ")) => {
                help = raxel(&[verb, word.as_str(), "--help"]).exits(0).stdout;
                true
            }
            _ => false,
        };
        if !fits {
            return Err(format!("raxel {verb} does not take `{word}`"));
        }
    }
    Ok(())
}
