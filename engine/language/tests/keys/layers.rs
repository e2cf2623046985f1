//! Tables that are laid over each other.

use raxel_diagnostics::table::read_document;
use raxel_diagnostics::{Diagnostic, SourceMap, codes};
use raxel_language::{ByName, Keys, Layer, Named, Node, Shape, Spanned, Table, Value, layer};

use crate::{messages, read};

/// A slider.
#[derive(Clone, Debug, Keys)]
#[keys(layer("slider", unknown = codes::graph::UNKNOWN_PARAM), over = one_beside, check = labelled(value, label))]
struct Slider {
    #[keys(entry)]
    name: Spanned<String>,
    /// Takes it away.
    #[keys(remove)]
    remove: bool,
    #[keys(flawed)]
    flawed: bool,
    /// Its value.
    value: Option<f64>,
    /// Text beside it.
    #[keys(excludes("icon", why = "there is room for one"))]
    label: Option<Spanned<String>>,
    /// Picture beside it.
    icon: Option<String>,
}

/// What stands beside a slider is one thing in the whole, too.
fn one_beside(below: &mut Slider, above: &Slider) {
    if above.label.is_some() || above.icon.is_some() {
        (below.label, below.icon) = (None, None);
    }
}

fn labelled(table: &Table<'_, '_>, value: Option<&f64>, label: Option<&Spanned<String>>) -> bool {
    let right = value.is_none_or(|value| *value < 9.0) || label.is_some();
    if !right && let Some(node) = table.get("value") {
        node.bad_value::<()>(format!("`{}` is large and has no label", table.name()));
    }
    right
}

fn sliders(text: &str) -> (Vec<Slider>, Vec<String>) {
    let mut read = Vec::new();
    let found = read_document("f.toml", text, &mut SourceMap::default(), |root| {
        read = ByName::read(&root.get("s")?, &(), &()).map(|sliders: ByName<Slider>| sliders.0)?;
        Some(())
    });
    (read, found.map_or_else(|found| found, |((), found)| found).into_iter().map(|found| found.message).collect())
}

#[test]
fn layers_are_read_whatever_is_wrong_with_them() {
    let (read, found) = sliders(
        r"[s.a]
value = 'x'
label = 'l'
[s.b]
label = 'l'
icon = 'i'
[s.c]
value = 1
vlaue = 2
[s.d]
[s.e]
remove = true
value = 1
[s.f]
value = 9
",
    );
    assert_eq!(
        found,
        [
            "`s.a.value` needs a number, not a string",
            "`label` and `icon` exclude each other: there is room for one",
            "`s.c` has no key `vlaue`",
            "`value` and `remove` exclude each other: a removed entry has no `value`",
            "`s.f` is large and has no label",
        ]
    );
    let flawed: Vec<_> = read.iter().map(|slider| (slider.name.value.as_str(), slider.flawed)).collect();
    assert_eq!(flawed, [("a", true), ("b", true), ("c", true), ("d", false), ("e", true), ("f", true)]);
    assert_eq!((read[0].value, read[0].label.as_ref().unwrap().value.as_str()), (None, "l"));
    assert!(read[4].remove && read[4].removed());
}

#[test]
fn layers_merge_key_by_key() {
    let (mut below, _) = sliders("[s.a]\nvalue = 1\nlabel = 'below'\n[s.b]\nvalue = 2\n[s.c]\n");
    let (above, _) = sliders(
        r"[s.d]
value = 4
[s.a]
value = 3
x = 0
[s.b]
remove = true
[s.bb]
remove = true
",
    );
    let mut found = Vec::new();
    layer::merge(&mut below, above, &mut found);
    let merged: Vec<_> = below.iter().map(|slider| (slider.name.value.as_str(), slider.value, slider.flawed)).collect();
    assert_eq!(merged, [("a", Some(3.0), true), ("c", None, false), ("d", Some(4.0), false)]);
    assert_eq!(below[0].label.as_ref().unwrap().value, "below");
    assert_eq!((found.len(), found[0].code), (1, codes::graph::UNKNOWN_PARAM));
    assert_eq!(found[0].message, "the base has no slider `bb`");
    assert_eq!(Slider::WHAT, "slider");
    let (mut below, _) = sliders("[s.a]\nlabel = 'text'\nvalue = 1\n");
    layer::merge(&mut below, sliders("[s.a]\nicon = 'sun'\n").0, &mut found);
    assert_eq!((&below[0].label, below[0].icon.as_deref(), below[0].value), (&None, Some("sun"), Some(1.0)));
    let form = Slider::form();
    assert!(form.keys.iter().all(|key| !key.needed), "a layer says what differs");
    assert_eq!(form.keys.iter().map(|key| key.name).collect::<Vec<_>>(), ["remove", "value", "label", "icon"]);
}

/// A plug, which is exchanged and not mended.
#[derive(Debug, Keys)]
#[keys(layer("plug", unknown = codes::graph::NOTHING_TO_OVERLAY, whole))]
struct Plug {
    #[keys(entry)]
    name: Spanned<String>,
    #[keys(remove)]
    remove: bool,
    /// Its pins.
    pins: Option<u32>,
    /// Its colour.
    color: Option<String>,
}

#[test]
fn a_whole_layer_replaces_its_equal() {
    let read = |text: &str| {
        let mut plugs = Vec::new();
        let _ = read_document("f.toml", text, &mut SourceMap::default(), |root| {
            plugs = ByName::read(&root.get("s")?, &(), &()).map(|plugs: ByName<Plug>| plugs.0)?;
            Some(())
        });
        plugs
    };
    let mut below = read("[s.a]\npins = 2\ncolor = 'red'\n[s.b]\n");
    let above = read("[s.a]\npins = 'x'\ncolor = 'blue'\n[s.b]\nremove = true\n");
    let mut found = Vec::new();
    layer::merge(&mut below, above, &mut found);
    assert_eq!((below.len(), &below[0].name.value[..], found.len()), (1, "a", 0));
    assert_eq!((below[0].pins, below[0].color.as_deref()), (None, Some("blue")), "pins of the base are gone");
}

/// A board, which says its name itself, with sliders on it.
#[derive(Clone, Debug, Keys)]
#[keys(layer("board", unknown = codes::graph::UNKNOWN_PASS), added = stays)]
struct Board {
    /// Its name.
    #[keys(name, rename = "title")]
    name: Spanned<String>,
    /// Takes it away.
    #[keys(remove)]
    remove: bool,
    #[keys(flawed)]
    flawed: bool,
    /// How wide it is.
    width: Option<f64>,
    /// What is on it.
    #[keys(read = by_name, shape = Shape::by_name(Shape::Table(Slider::form())))]
    sliders: Vec<Slider>,
    /// The large one.
    #[keys(cover, read = large, shape = Shape::Table(Slider::form()))]
    large: Option<Slider>,
}

fn by_name(node: &Node<'_, '_>) -> Option<Vec<Slider>> {
    ByName::read(node, &(), &()).map(|sliders: ByName<Slider>| sliders.0)
}

fn large(node: &Node<'_, '_>) -> Option<Slider> {
    Named::read_named(Spanned::new("large".to_owned(), node.key_span.clone()), &node.table()?, &())
}

fn stays(board: &Board, found: &mut Vec<Diagnostic>) {
    let removed = board.sliders.iter().filter(|slider| slider.remove);
    found.extend(removed.map(|slider| layer::unknown(Slider::WHAT, Slider::UNKNOWN, &slider.name, [].into_iter())));
}

#[test]
fn layers_have_layers_in_them() {
    let read = |text: &str| {
        let mut boards = Vec::new();
        let found = read_document("f.toml", text, &mut SourceMap::default(), |root| {
            boards = root.get("b")?.array()?.iter().filter_map(|node| Board::read(node, &(), &())).collect();
            Some(())
        });
        let found = found.map_or_else(|found| found, |((), found)| found);
        (boards, found.into_iter().map(|found| found.message).collect::<Vec<_>>())
    };
    let (mut below, found) = read(
        r"[[b]]
title = 'a'
width = 1
large.label = 'l'
[b.sliders.x]
value = 1
[[b]]
title = 'b'
",
    );
    assert_eq!(found, [""; 0]);
    let (above, found) = read(
        r"[[b]]
title = 'a'
large.value = 2
[b.sliders.x]
label = 'x'
[b.sliders.y]
[[b]]
title = 'b'
remove = true
[[b]]
title = 'c'
sliders.z.remove = true
",
    );
    assert_eq!(found, [""; 0]);
    let mut found = Vec::new();
    layer::merge(&mut below, above, &mut found);
    let names: Vec<_> = below.iter().map(|board| board.name.value.as_str()).collect();
    assert_eq!((names, below[0].width), (vec!["a", "c"], Some(1.0)));
    let x = &below[0].sliders[0];
    assert_eq!(
        (x.value, x.label.as_ref().map(|label| &label.value[..]), below[0].sliders.len()),
        (Some(1.0), Some("x"), 2)
    );
    let large = below[0].large.as_ref().expect("it is there in both");
    assert_eq!((large.value, large.label.as_ref().map(|label| &label.value[..])), (Some(2.0), Some("l")));
    let found: Vec<_> = found.iter().map(|found| found.message.as_str()).collect();
    assert_eq!(found, ["the base has no slider `z`"], "a board that is new has nothing to remove");
    assert!(read("[[b]]\n").0[0].flawed, "it has no name");
    let (flawed, found) = read("[[b]]\nwidth = 'w'\n[[b]]\ntitle = 'd'\nremove = true\nwidth = 1\n");
    assert_eq!(
        found,
        [
            "`b[0]` needs the key `title`",
            "`b[0].width` needs a number, not a string",
            "`width` and `remove` exclude each other: a removed entry has no `width`",
        ]
    );
    assert!(flawed[0].name.value.is_empty() && flawed.iter().all(|board| board.flawed));
    let form = Board::form();
    assert!(form.keys[0].needed && form.keys[0].name == "title" && !form.keys[1].needed);
}

/// A whole file.
#[derive(Debug, Keys)]
#[keys(layer)]
struct Desk {
    #[keys(skip)]
    opened: usize,
    /// Who sits at it.
    owner: Option<String>,
    /// How wide it is.
    #[keys(range = 0.0..=9.0)]
    width: Option<f64>,
    /// What is on it.
    #[keys(read = by_name, shape = Shape::by_name(Shape::Table(Slider::form())))]
    sliders: Vec<Slider>,
}

#[test]
fn a_whole_file_is_laid_over_another() {
    let mut below: Desk = read("owner = 'a'\nwidth = 1\n[sliders.x]\nvalue = 1\n").unwrap();
    let above: Desk = read("owner = 'b'\n[sliders.x]\nlabel = 'x'\n[sliders.y]\n").unwrap();
    below.opened = 3;
    let mut found = Vec::new();
    below.cover(above, &mut found);
    assert_eq!((below.owner.as_deref(), below.width, below.sliders.len()), (Some("b"), Some(1.0), 2));
    assert_eq!((below.sliders[0].value, below.opened, found.len()), (Some(1.0), 3, 0));
    assert_eq!(
        messages::<Desk>("owner = 1\nwidth = 10\nsliders = 2\nowwner = 3"),
        [
            "`owner` needs a string, not an integer",
            "`width` is 10; it must be in 0…9",
            "`sliders` needs a table, not an integer",
            "the file has no key `owwner`",
        ]
    );
    assert!(Desk::form().keys.iter().all(|key| !key.needed), "the other file may have it");
}
