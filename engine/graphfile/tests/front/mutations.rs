//! For any damage to a graph file, the compiler answers with a graph or with diagnostics that point into texts, never with a panic.

use std::sync::LazyLock;

use proptest::prelude::*;

use crate::files::{GRAPH, Project};

/// One change to a text.
#[derive(Clone, Debug)]
enum Edit {
    /// Replaces some characters.
    Splice { at: usize, length: usize, with: String },
    /// Repeats some lines elsewhere.
    CopyLines { from: usize, count: usize, to: usize },
    /// Takes the value of one line and gives it to another.
    SwapValues { a: usize, b: usize },
}

fn edit() -> impl Strategy<Value = Edit> {
    let piece = prop_oneof![
        "[\\[\\]{}=\",.@!#0-9a-z\n _-]{0,6}",
        prop::sample::select(vec![
            "-1",
            "0",
            "1e300",
            "nan",
            "18446744073709551616",
            "\"\"",
            "[]",
            "{}",
            "true",
            "\"full\"",
            "\"hit\"",
            "\"color@9\"",
            "[[[1]]]",
            "0xffff_ffff",
            "1979-05-27",
            "\u{1f600}",
            "\0",
        ])
        .prop_map(str::to_owned),
    ];
    prop_oneof![
        (any::<usize>(), 0_usize..12, piece).prop_map(|(at, length, with)| Edit::Splice { at, length, with }),
        (any::<usize>(), 1_usize..8, any::<usize>()).prop_map(|(from, count, to)| Edit::CopyLines { from, count, to }),
        (any::<usize>(), any::<usize>()).prop_map(|(a, b)| Edit::SwapValues { a, b }),
    ]
}

fn apply(text: &str, edit: &Edit) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let count = lines.len().max(1);
    match edit {
        Edit::Splice { at, length, with } => {
            let characters: Vec<char> = text.chars().collect();
            let start = at % (characters.len() + 1);
            let end = (start + length).min(characters.len());
            return characters[..start]
                .iter()
                .chain(&with.chars().collect::<Vec<_>>())
                .chain(&characters[end..])
                .collect();
        }
        Edit::CopyLines { from, count: copied, to } => {
            let from = from % count;
            let copied: Vec<String> = lines.iter().skip(from).take(*copied).cloned().collect();
            let to = to % count;
            lines.splice(to..to, copied);
        }
        Edit::SwapValues { a, b } => {
            let assigned: Vec<usize> = (0..lines.len()).filter(|line| lines[*line].contains(" = ")).collect();
            if let [_, ..] = assigned[..] {
                let (a, b) = (assigned[a % assigned.len()], assigned[b % assigned.len()]);
                let value = lines[b].split_once(" = ").map(|(_, value)| value.to_owned());
                if let (Some((key, _)), Some(value)) = (lines[a].clone().split_once(" = "), value) {
                    lines[a] = format!("{key} = {value}");
                }
            }
        }
    }
    lines.join("\n")
}

static PROJECT: LazyLock<Project> = LazyLock::new(Project::new);

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn no_edit_of_a_graph_makes_the_compiler_panic(edits in prop::collection::vec(edit(), 1..5)) {
        let mut project = PROJECT.clone();
        let text = edits.iter().fold(GRAPH.to_owned(), |text, edit| apply(&text, edit));
        project.put("graphs/base.toml", &text);
        // Renders the diagnostics, and checks that every label points into a text.
        project.rendered("graphs/base.toml");
    }

    #[test]
    fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let mut project = PROJECT.clone();
        project.files.insert("graphs/base.toml".to_owned(), bytes.into());
        project.rendered("graphs/base.toml");
    }
}
